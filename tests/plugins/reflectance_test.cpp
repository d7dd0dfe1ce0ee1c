// The reflectance array as a plugin, over a floor with a black line.
#include <catch2/catch.hpp>
#include <cmath>

#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/model/surface.h"
#include "cogrsim/rays/ray_caster.h"
#include "cogrsim/rendering/renderer.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

/// The context of a sensor, at chosen poses.
class Bench final : public SensorContext {
 public:
  explicit Bench(SceneModelPtr model) {
    frame_.model = model;
    for (const Body& body : model->bodies) frame_.state.poses.push_back(body.X_WB);
  }
  void place(int body, const Pose& pose) { frame_.state.poses[body] = pose; }
  const Frame& frame() const override { return frame_; }
  const RayCaster& rays() override {
    rays_.update(frame_.model, frame_.state.poses);
    return rays_;
  }
  Color surface_color(const RayHit& hit) override {
    const SceneModel& model = *frame_.model;
    const auto body = static_cast<std::size_t>(hit.body);
    const Shape& shape = model.bodies[body].shapes[hit.shape];
    const Material& material = model.materials[shape.material];
    const auto picture = textures_.texture(material);
    if (!picture) return material.color;
    const Pose X_SW = (frame_.state.poses[body] * shape.X_BS).inverse();
    const Color texel =
        sample(*picture, texture_coordinates(model, shape, X_SW * hit.point, X_SW.q * hit.normal));
    const Color& c = material.color;
    return {c.r * texel.r, c.g * texel.g, c.b * texel.b, c.a * texel.a};
  }
  Result<std::vector<Picture>> render(const std::vector<RenderRequest>&) override {
    return fail("no pictures here");
  }

 private:
  Frame frame_;
  RayCaster rays_;
  TextureStore textures_;
};

struct Loaded {
  std::shared_ptr<PluginLoader> loader = std::make_shared<PluginLoader>();
  SceneModelPtr model;
  Loaded() {
    dsl::LoaderCatalog catalog(loader);
    dsl::CompileOptions options;
    options.plugins = &catalog;
    const auto result = dsl::compile_file(COGRSIM_PLUGIN_TEST_SCENES "/line.scene.xml", options);
    INFO(dsl::to_text(result.diagnostics));
    REQUIRE(result.ok());
    model = result.model;
  }
};

/// Codes of the diagnostics of a sled with these settings of its sensor.
std::string codes(const std::string& set, dsl::PluginCatalog* catalog) {
  dsl::CompileOptions options;
  options.plugins = catalog;
  std::string out;
  const auto result = dsl::compile_text(
      "<scene version='1'><box name='sled' size='1 1 1' mass='1'/>"
      "<sensor name='eye' plugin='reflectance' on='sled'>" +
          set + "</sensor></scene>",
      "sled.scene.xml", options);
  for (const Diagnostic& d : result.diagnostics) out += (out.empty() ? "" : " ") + d.code;
  return out;
}

constexpr double kHeight = 0.03;  // of the sled; its sensor is 2 cm above the floor

}  // namespace

TEST_CASE("a program's scenes have their parameters checked by the plugins, or not at all") {
  dsl::LoaderCatalog catalog;
  CHECK(codes("<set pitch='5 mm'/>", &catalog).empty());
  CHECK(codes("<set pitch='50 deg'/>", &catalog) == "CG0502");
  CHECK(codes("<set pich='5 mm'/>", &catalog) == "CG0904");
  CHECK(codes("<set pitch='50 deg'/>", nullptr) == "CG0909");
  CHECK(codes("<set pitch='5 mm'/>", nullptr) == "CG0909");
  CHECK(codes("", nullptr).empty());
}

TEST_CASE("a reflectance array sees the line on the floor where it is") {
  const Loaded loaded;
  const auto plugin = loaded.loader->load(PluginKind::sensor, "reflectance");
  REQUIRE(plugin);
  const auto* entry = static_cast<const SensorEntry*>((*plugin)->descriptor().factory);
  const std::unique_ptr<Sensor, void (*)(Sensor*)> sensor(entry->create(), entry->destroy);
  const SceneModel& model = *loaded.model;
  Parameters given = model.sensors[0].parameters;
  const auto configure = [&] {
    const auto complete = complete_parameters((*plugin)->descriptor().parameters, given);
    REQUIRE(complete);
    REQUIRE(sensor->configure(model, model.sensors[0], *complete));
  };
  configure();
  REQUIRE(sensor->channels().size() == 5);
  CHECK(sensor->channels()[0].name == "element_1");

  Bench bench(loaded.model);
  const int sled = find_body(model, "sled");
  const auto read_at = [&](const Vec3& position, double heading) {
    bench.place(sled, {position, Quat(Eigen::AngleAxisd(heading, Vec3::UnitZ()))});
    Reading reading;
    reading.values.resize(sensor->channels().size());
    REQUIRE(sensor->read(bench, reading));
    return reading.values;
  };
  using Values = std::vector<double>;
  const auto is_near = [](const Values& a, const Values& b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i] - b[i]) > 1e-12) return false;
    return true;
  };
  // The line covers y = 49 to 51 cm; the picture blends over half a pixel, 5 mm, on both sides, and
  // the spots have a radius of 2 mm. Elements sit at +2, +1, 0, -1 and -2 cm.
  SECTION("in the middle of the line") {
    const Values v = read_at({0.3, 0.5, kHeight}, 0.0);
    CHECK(v[0] == Approx(1.0));
    CHECK(v[2] == Approx(0.0).margin(1e-12));
    CHECK(v[4] == Approx(1.0));
    // On the edges half of the light, at least by symmetry.
    CHECK(v[1] == Approx(v[3]));
    CHECK(v[1] > 0.1);
    CHECK(v[1] < 0.5);
  }
  SECTION("off to one side the other elements see it") {
    const Values v = read_at({0.3, 0.48, kHeight}, 0.0);
    CHECK(v[0] == Approx(0.0).margin(1e-12));
    CHECK(v[2] == Approx(1.0));
    CHECK(v[4] == Approx(1.0));
    CHECK(is_near(v, [&] {
      Values back = read_at({0.7, 0.52, kHeight}, std::acos(-1.0));
      return back;
    }()));
  }
  SECTION("turned by a right angle all elements see the same") {
    const Values v = read_at({0.3, 0.5, kHeight}, std::acos(0.0));
    for (const double value : v) CHECK(value == Approx(0.0).margin(1e-9));
  }
  SECTION("too high above the floor nothing comes back") {
    CHECK(is_near(read_at({0.3, 0.2, kHeight + 0.0299}, 0.0), Values(5, 1.0)));
    CHECK(is_near(read_at({0.3, 0.2, kHeight + 0.0301}, 0.0), Values(5, 0.0)));
  }
  SECTION("a spot of no size is one ray, one element sits in the middle") {
    given["elements"] = std::int64_t{1};
    given["spot"] = 0.0;
    configure();
    CHECK(is_near(read_at({0.3, 0.5, kHeight}, 0.0), {0.0}));
    // A quarter of a pixel inside the white: 3/4 of the way from black to white in sRGB steps.
    const double half = 0.75;
    CHECK(read_at({0.3, 0.5125, kHeight}, 0.0)[0] == Approx(std::pow((half + 0.055) / 1.055, 2.4)));
  }
  SECTION("no range is refused") {
    given["range"] = 0.0;
    const auto complete = complete_parameters((*plugin)->descriptor().parameters, given);
    REQUIRE(complete);
    const auto done = sensor->configure(model, model.sensors[0], *complete);
    REQUIRE_FALSE(done);
    CHECK(done.error().message == "range must be more than 0 m");
  }
}

TEST_CASE("a reflectance array reads in a run") {
  const Loaded loaded;
  SimulationOptions options;
  options.backend = "bullet";
  auto simulation = Simulation::create(loaded.model, options, loaded.loader);
  REQUIRE(simulation);
  REQUIRE((*simulation)->run_until(0.01) == RunStatus::completed);
  const FramePtr frame = (*simulation)->frame();
  REQUIRE(frame->readings.size() == 1);
  const Reading& reading = frame->readings[0];
  REQUIRE(reading.valid);
  REQUIRE(reading.values.size() == 5);
  CHECK(reading.values[0] == Approx(1.0));
  CHECK(reading.values[2] == Approx(0.0).margin(1e-12));
  CHECK(reading.values[4] == Approx(1.0));
}

TEST_CASE("a change of step counts all the values that a sensor has under way") {
  auto loader = std::make_shared<PluginLoader>();
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions compiling;
  compiling.plugins = &catalog;
  const auto result = dsl::compile_text(
      "<scene version='1'><box name='sled' size='1 1 1' mass='1'/>"
      "<sensor name='eye' plugin='reflectance' on='sled' latency='10 s'>"
      "<set elements='64'/></sensor></scene>",
      "sled.scene.xml", compiling);
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.ok());
  SimulationOptions options;
  options.backend = "bullet";
  const auto created = Simulation::create(result.model, options, loader);
  REQUIRE(created);
  Simulation& simulation = **created;
  // 64 values for 10 s are 6.4e6 and 2.1e7 numbers, and 1e7 is the limit; 16 values would be 5.3e6.
  simulation.send(SetStep{1e-4});
  simulation.step();
  CHECK(simulation.dt() == 1e-4);
  simulation.send(SetStep{3e-5});
  simulation.step();
  CHECK(simulation.dt() == 1e-4);
  REQUIRE_FALSE(simulation.messages().empty());
  CHECK_THAT(simulation.messages().back().message,
             Catch::Contains("sensor 'eye' has a latency of 10 s"));
}
