// The simulation's part of cameras: their times, poses and noise. The
// pictures here come from a renderer that counts; those of the real one are tested with it.
#include <cmath>

#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor_models.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SensorModel camera(const std::string& name, int body, const Vec3& at = Vec3::Zero()) {
  SensorModel model;
  model.name = name;
  model.type = "camera";
  model.body = body;
  model.X_BS.p = at;
  model.parameters["resolution"] = std::vector<double>{64, 48};
  return model;
}

}  // namespace

TEST_CASE("a camera that is off or not due costs no picture", "[sensors][camera]") {
  ModelBuilder builder("cameras");
  builder.model.sensors = {camera("on", kWorld), camera("off", kWorld)};
  builder.model.sensors[0].rate = 10.0;
  builder.model.sensors[1].enabled = false;
  auto simulation = simulate(builder.build(), "bullet");
  simulation->run_until(1.0);
  FramePtr frame = simulation->frame();
  REQUIRE(frame->readings[0].picture);
  // The renderer labels its pictures with their number: one for each of the ten readings.
  CHECK(frame->readings[0].sequence == 10);
  CHECK(frame->readings[0].picture->bodies[0] == 10);
  CHECK_FALSE(frame->readings[1].picture);
  simulation->send(EnableSensor{"off", true});
  simulation->send(EnableSensor{"on", false});
  simulation->step();
  frame = simulation->frame();
  REQUIRE(frame->readings[1].picture);
  CHECK(frame->readings[1].picture->bodies[0] == 11);
  CHECK(frame->readings[0].sequence == 10);
}

TEST_CASE("noise on a picture has the right moments and is repeatable", "[sensors][camera]") {
  ModelBuilder builder("noisy");
  builder.model.sensors = {camera("eye", kWorld)};
  builder.model.sensors[0].parameters["depth"] = true;
  builder.model.sensors[0].noise = {{NoiseTerm::Kind::normal, 0.0, 0.05, 0},
                                    {NoiseTerm::Kind::normal, 0.0, 0.02, 1},
                                    {NoiseTerm::Kind::dropout, 0.1, 0.0, 1}};
  const SceneModelPtr scene = builder.build();
  const auto shoot = [&] {
    auto simulation = simulate(scene, "bullet");
    simulation->step();
    return simulation->frame()->readings[0];
  };
  const Reading reading = shoot();
  REQUIRE(reading.picture);
  double sum = 0.0, squares = 0.0;
  for (const std::uint8_t v : reading.picture->color.data) {
    sum += v / 255.0;
    squares += std::pow(v / 255.0 - 0.4, 2);
  }
  const auto n = static_cast<double>(reading.picture->color.data.size());  // 9216
  // Mean to 5 * 0.05 / sqrt(n) = 0.0026; variance to 5 sqrt(2 / n) = 7.4 %, and rounding to 1/255
  // adds (1/255)^2 / 12, 0.05 %.
  CHECK(sum / n == Approx(0.4).margin(0.0026));
  CHECK(squares / n == Approx(0.0025).epsilon(0.075));
  CHECK(reading.values[0] == Approx(sum / n).margin(1e-12));
  int holes = 0;
  double depth_squares = 0.0;
  for (const float depth : reading.picture->depth) {
    if (std::isnan(depth)) {
      ++holes;
    } else {
      depth_squares += std::pow(depth - 2.0, 2);
    }
  }
  const auto pixels = static_cast<double>(reading.picture->depth.size());  // 3072
  // Binomial: 0.1 +- 5 sqrt(0.09 / 3072) = 0.027; variance to 5 sqrt(2 / 2765) = 13 %.
  CHECK(holes / pixels == Approx(0.1).margin(0.027));
  CHECK(depth_squares / (pixels - holes) == Approx(4e-4).epsilon(0.14));
  const Reading again = shoot();
  CHECK(again.picture->color.data == reading.picture->color.data);
}

TEST_CASE("a camera is carried along, and built into its body does not see it",
          "[sensors][camera]") {
  ModelBuilder builder("carried");
  const int cart =
      builder.box("cart", Vec3(0.4, 0.2, 0.1), 1.0, Pose(Vec3(1, 2, 3), Quat(1, 0, 0, 0)));
  builder.model.sensors = {camera("outside", cart, Vec3(0.3, 0, 0)),
                           camera("inside", cart, Vec3(0.1, 0, 0))};
  const SceneModelPtr model = builder.build();
  WorldState state;
  const Quat quarter(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  state.poses = {Pose(Vec3(5, 5, 0), quarter)};
  state.twists.resize(1);
  const auto outside = camera_request(*model, model->sensors[0], state);
  const auto inside = camera_request(*model, model->sensors[1], state);
  REQUIRE(outside);
  REQUIRE(inside);
  CHECK((outside->camera.X_WC.p - Vec3(5, 5.3, 0)).norm() < 1e-12);
  CHECK((outside->camera.X_WC.q * Vec3::UnitX() - Vec3::UnitY()).norm() < 1e-12);
  CHECK(outside->camera.width == 64);
  CHECK(outside->hidden_bodies.empty());
  CHECK(inside->hidden_bodies == std::vector<int>{cart});
}

TEST_CASE("a camera inside any shape of another body is refused", "[sensors][camera]") {
  const auto said = [](const Vec3& at) {
    ModelBuilder builder("inside");
    TriangleMesh corner;  // a tetrahedron with corners at the origin and 1 along each axis
    corner.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    corner.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    HeightGrid hill;
    hill.columns = hill.rows = 3;
    hill.size_x = hill.size_y = 2.0;
    hill.heights = {0, 0, 0, 0, 1, 0, 0, 0, 0};
    const Quat upright(1, 0, 0, 0);
    builder.plane("floor", Pose(Vec3(0, 0, -1), upright));
    builder.sphere("ball", 0.5, 1.0, Pose(Vec3(10, 0, 5), upright));
    builder.cylinder("drum", 0.5, 1.0, 1.0, Pose(Vec3(20, 0, 5), upright));
    builder.capsule("bar", 0.5, 1.0, 1.0, Pose(Vec3(30, 0, 5), upright));
    builder.mesh("corner", corner, true, 0.0, Pose(Vec3(40, 0, 5), upright));
    builder.heightmap("hill", hill, Pose(Vec3(50, 0, 5), upright));
    builder.model.sensors = {camera("eye", kWorld, at)};
    const auto found = buried_cameras(*builder.build());
    return found.empty() ? std::string() : found[0].error.message;
  };
  CHECK(said(Vec3(0, 0, -1.1)).find("'floor'") != std::string::npos);
  CHECK(said(Vec3(10.4, 0, 5)).find("'ball'") != std::string::npos);
  CHECK(said(Vec3(20, 0.4, 5.4)).find("'drum'") != std::string::npos);
  CHECK(said(Vec3(30, 0, 5.9)).find("'bar'") != std::string::npos);
  CHECK(said(Vec3(40.2, 0.2, 5.2)).find("'corner'") != std::string::npos);
  CHECK(said(Vec3(50, 0, 5.9)).find("'hill'") != std::string::npos);
  // Just outside each of them.
  for (const Vec3& at : {Vec3(0, 0, -0.9), Vec3(10.4, 0, 5.4), Vec3(20, 0.4, 5.6),
                         Vec3(30, 0.2, 5.99), Vec3(40.4, 0.4, 5.4), Vec3(50, 0, 6.1)}) {
    CHECK(said(at).empty());
  }
  ModelBuilder builder("refused");
  builder.box("crate", Vec3(1, 1, 1), 0.0, Pose{});
  builder.model.sensors = {camera("eye", kWorld)};
  CHECK(refusal(builder.build(), "bullet").find("CG0711") != std::string::npos);
}

TEST_CASE("a camera that can take no picture is refused with the limit", "[sensors][camera]") {
  const auto said = [](const char* name, const ParameterValue& value) {
    ModelBuilder builder("refused");
    builder.model.sensors = {camera("eye", kWorld)};
    builder.model.sensors[0].parameters[name] = value;
    return refusal(builder.build(), "bullet");
  };
  CHECK(said("resolution", std::vector<double>{0, 48}).find("at least 1") != std::string::npos);
  CHECK(said("resolution", std::vector<double>{10000, 10000}).find("64000000") !=
        std::string::npos);
  CHECK(said("near", 200.0).find("near < far") != std::string::npos);
  CHECK(said("fov", 3.5).find("CG0710") != std::string::npos);
  CHECK(said("samples", std::int64_t{3}).find("1, 2, 4 or 8") != std::string::npos);
}

#ifdef COGRSIM_TEST_RENDERER
TEST_CASE("a camera on a moving cart sees the wall come nearer", "[sensors][camera]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("approach");
  builder.model.physics.gravity = Vec3::Zero();
  const Quat upright(1, 0, 0, 0);
  const int cart = builder.box("cart", Vec3(0.4, 0.2, 0.1), 1.0, Pose(Vec3(0, 0, 1), upright));
  builder.model.bodies[cart].V_WB.linear = Vec3(1, 0, 0);
  const int wall = builder.box("wall", Vec3(0.2, 4, 4), 0.0, Pose(Vec3(3.1, 0, 1), upright));
  builder.model.sensors = {camera("eye", cart, Vec3(0.25, 0, 0))};
  builder.model.sensors[0].rate = 5.0;
  builder.model.sensors[0].parameters["depth"] = true;
  builder.model.sensors[0].parameters["segmentation"] = true;
  SimulationOptions options;
  options.backend = backend;
  options.step = 0.01;
  auto simulation = Simulation::create(builder.build(), options, std::make_shared<PluginLoader>());
  REQUIRE(simulation);
  std::uint64_t seen = 0;
  (*simulation)->observe({}, [&](const FramePtr& frame) {
    const Reading& reading = frame->readings[0];
    if (reading.sequence == seen) return;
    seen = reading.sequence;
    REQUIRE(reading.picture);
    const Picture& picture = *reading.picture;
    const std::size_t middle = 24 * 64 + 32;
    // Free motion: x = t on any engine. Depth is exact to 1e-3 of the distance.
    const double expected = 3.0 - 0.25 - reading.time;
    CHECK(picture.depth[middle] == Approx(expected).epsilon(1e-3));
    CHECK(picture.bodies[middle] == wall);
    CHECK(reading.values[1] == Approx(expected).epsilon(1e-3));
  });
  (*simulation)->run_until(1.5);
  CHECK(seen == 8);
  CHECK(messages_of(**simulation).empty());
}
#endif
