// Values that are drawn for each run.
#include <cmath>
#include <set>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/model/randomize.h"
#include "cogrsim/simulation/batch.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

SceneModelPtr compiled(const std::string& inside) {
  const auto result = dsl::compile_text("<scene>" + inside + "</scene>", "drawn.scene.xml");
  INFO(dsl::to_text(result.diagnostics));
  REQUIRE(result.model != nullptr);
  return result.model;
}

/// A ball that rolls on a floor, and a box on a slider.
SceneModelPtr scene(const std::string& randomize) {
  return compiled(R"xml(<plane name="floor"/>
    <sphere name="ball" radius="5 cm" mass="2 kg" xyz="0 0 5 cm"/>
    <assembly name="arm">
      <box name="a" size="10 10 10 cm" mass="1 kg" xyz="1 0 1"/>
      <box name="b" size="10 10 10 cm" mass="3 kg" xyz="1 1 1"/>
      <slider name="s" child="a" axis="1 0 0" damping="4 N*s/m"/>
      <servo name="push" joint="s" kp="100 N/m" kd="20 N*s/m" target="10 cm"/>
      <imu name="imu" on="b" noise="normal(0, 0.5)"/>
    </assembly>)xml" +
                  randomize);
}

SceneModelPtr drawn(const SceneModelPtr& model, std::uint64_t seed) {
  auto seeded = std::make_shared<SceneModel>(*model);
  seeded->physics.seed = seed;
  return with_drawn_values(seeded);
}

double value(const SceneModel& model, const std::string& quantity) {
  for (const DrawnValue& it : model.drawn)
    if (it.quantity == quantity) return it.value;
  FAIL("not drawn: " << quantity);
  return 0.0;
}

const Body& body(const SceneModel& model, const std::string& name) {
  return model.bodies[find_body(model, name)];
}

}  // namespace

TEST_CASE("patterns of names", "[randomize]") {
  CHECK(matches_pattern("arm.a.mass", "arm.*.mass"));
  CHECK(matches_pattern("arm.left.a.mass", "arm.*.mass"));
  CHECK(matches_pattern("arm.a.mass", "*"));
  CHECK(matches_pattern("arm.a.mass", "*.mass"));
  CHECK_FALSE(matches_pattern("arm.mass", "arm.*.mass"));
  CHECK_FALSE(matches_pattern("arm.a.mass", "arm.*.mas"));
  CHECK_FALSE(matches_pattern("arm.a.massive", "*.mass"));
}

TEST_CASE("every kind of quantity is drawn and written to the model", "[randomize]") {
  const auto model = scene(R"xml(
    <wind name="breeze" velocity="1 0 2 m/s"/>
    <buoyancy name="water" on="ball" level="-1 m"/>
    <randomize what="breeze.x" to="uniform(3 m/s, 4 m/s)"/>
    <randomize what="water.density" by="uniform(1.02, 1.03)"/>
    <randomize what="arm.*.mass" by="uniform(2, 3)"/>
    <randomize what="ball.com.z" add="uniform(1 mm, 2 mm)"/>
    <randomize what="ball.x" to="uniform(20 cm, 30 cm)"/>
    <randomize what="ball.friction" to="choice(0.25, 0.75)"/>
    <randomize what="arm.z" add="uniform(1 m, 2 m)"/>
    <randomize what="arm.s.damping" by="loguniform(0.1, 10)"/>
    <randomize what="arm.push.kp" to="normal(100 N/m, 1 N/m)"/>
    <randomize what="arm.imu.noise-sigma" by="uniform(2, 3)"/>)xml");
  const auto one = drawn(model, 7);
  CHECK(one->drawn.size() == 11);
  CHECK(one->forces[0].wind == Vec3(value(*one, "breeze.x"), 0.0, 2.0));
  CHECK(one->forces[1].density >= 1020.0);
  CHECK(one->forces[1].density < 1030.0);
  const Body& a = body(*one, "arm.a");
  CHECK(a.mass >= 2.0);
  CHECK(a.mass < 3.0);
  CHECK(a.mass == value(*one, "arm.a.mass"));
  // A box of 10 cm: m (0.1^2 + 0.1^2) / 12, rounded a few times.
  CHECK(a.inertia(0, 0) == Approx(a.mass * 0.02 / 12.0).epsilon(1e-12));
  CHECK(body(*one, "arm.b").mass / 3.0 != a.mass);
  CHECK(body(*one, "ball").com.z() == value(*one, "ball.com.z"));
  CHECK(body(*one, "ball").X_WB.p.x() == Approx(value(*one, "ball.x")).epsilon(1e-12));
  const Shape& shape = body(*one, "ball").shapes.at(0);
  const double friction = one->materials[shape.material].friction;
  CHECK((friction == 0.25 || friction == 0.75));
  // The assembly moves with its slide on the world.
  const double up = value(*one, "arm.z");
  CHECK(a.X_WB.p.z() == Approx(1.0 + up).epsilon(1e-12));
  CHECK(one->joints[0].X_PF.p.z() == Approx(1.0 + up).epsilon(1e-12));
  CHECK(one->joints[0].axes[0].damping >= 0.4);
  CHECK(one->joints[0].axes[0].damping <= 40.0);
  CHECK(one->motors[0].kp == value(*one, "arm.push.kp"));
  CHECK(one->sensors[0].noise[0].b >= 1.0);
  CHECK(one->sensors[0].noise[0].b < 1.5);
  // The same seed gives the same values, another one others, and an element more changes nothing.
  const auto again = drawn(model, 7), other = drawn(model, 8);
  for (std::size_t i = 0; i < one->drawn.size(); ++i)
    CHECK(again->drawn[i].value == one->drawn[i].value);
  CHECK(value(*other, "arm.a.mass") != value(*one, "arm.a.mass"));
  const auto more = scene(R"xml(<sphere name="another" radius="1 cm" xyz="3 0 1"/>
    <randomize what="*.mass" by="uniform(0.5, 0.6)"/>
    <randomize what="arm.s.damping" by="loguniform(0.1, 10)"/>)xml");
  CHECK(value(*drawn(more, 7), "arm.s.damping") == value(*one, "arm.s.damping"));
}

TEST_CASE("together gives all the same number", "[randomize]") {
  const auto model = scene("<randomize what=\"*.mass\" by=\"uniform(0.5, 2)\" together=\"true\"/>");
  const auto one = drawn(model, 3);
  const double factor = value(*one, "ball.mass") / 2.0;
  CHECK(value(*one, "arm.a.mass") == Approx(factor).epsilon(1e-12));
  CHECK(value(*one, "arm.b.mass") == Approx(3.0 * factor).epsilon(1e-12));
}

TEST_CASE("distributions have their bounds and means", "[randomize]") {
  struct Case {
    std::string distribution;
    double mean, sigma, low, high;
  };
  const double inf = std::numeric_limits<double>::infinity();
  // loguniform(1, 4): mean (b - a) / ln(b/a), mean square (b^2 - a^2) / (2 ln(b/a)).
  const double l = std::log(4.0);
  const Case it = GENERATE_COPY(
      Case{"uniform(1, 4)", 2.5, 3.0 / std::sqrt(12.0), 1.0, 4.0},
      Case{"normal(4, 0.5)", 4.0, 0.5, 0.0, inf},
      Case{"loguniform(1, 4)", 3.0 / l, std::sqrt(15.0 / (2.0 * l) - 9.0 / (l * l)), 1.0, 4.0},
      Case{"choice(1, 2, 6)", 3.0, std::sqrt(14.0 / 3.0), 1.0, 6.0});
  CAPTURE(it.distribution);
  const auto model = scene("<randomize what=\"ball.mass\" to=\"" + it.distribution + "\"/>");
  constexpr int kRuns = 4000;
  double sum = 0.0;
  std::set<double> values;
  for (int seed = 0; seed < kRuns; ++seed) {
    const double mass = body(*drawn(model, static_cast<std::uint64_t>(seed)), "ball").mass;
    REQUIRE(mass >= it.low);
    REQUIRE(mass <= it.high);
    sum += mass;
    values.insert(mass);
  }
  // Five standard deviations of the mean: passed by chance alone in all but 1 of 1.7 million.
  CHECK(sum / kRuns == Approx(it.mean).margin(5.0 * it.sigma / std::sqrt(kRuns)));
  if (it.distribution[0] == 'c') CHECK(values == std::set<double>{1.0, 2.0, 6.0});
}

TEST_CASE("a number that makes a value impossible is drawn again", "[randomize]") {
  const auto model = scene("<randomize what=\"ball.mass\" to=\"normal(1 kg, 2 kg)\"/>");
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    CHECK(body(*drawn(model, seed), "ball").mass > 0.0);
}

TEST_CASE("engines get equal draws, and a restart draws with its seed", "[randomize]") {
  const auto model = scene(R"xml(<randomize what="arm.a.mass" by="uniform(0.5, 2)"/>
    <randomize what="arm.s.damping" by="uniform(0.5, 2)"/>)xml");
  SimulationOptions options;
  options.seed = 5;
  const std::string backend = GENERATE(engines());
  const double mass = body(*drawn(model, 5), "arm.a").mass;
  auto simulation = simulate(model, backend, options);
  CHECK(body(*simulation->model(), "arm.a").mass == mass);
  simulation->run_until(0.1);
  const std::uint64_t hash = state_hash(simulation->frame()->state);
  const SimulationSnapshotPtr saved = simulation->save();

  simulation->send(Restart{6});
  simulation->step();
  CHECK(body(*simulation->model(), "arm.a").mass == body(*drawn(model, 6), "arm.a").mass);
  simulation->run_until(0.1);
  const std::uint64_t second = state_hash(simulation->frame()->state);
  CHECK(second != hash);
  options.seed = 6;
  auto fresh = simulate(model, backend, options);
  fresh->run_until(0.1);
  CHECK(state_hash(fresh->frame()->state) == second);

  simulation->send(Restart{5});
  simulation->step();
  simulation->run_until(0.1);
  CHECK(state_hash(simulation->frame()->state) == hash);
  simulation->send(Restart{6});
  simulation->step();
  REQUIRE(simulation->restore(saved));  // of a run with other values
  CHECK(body(*simulation->model(), "arm.a").mass == mass);
  CHECK(state_hash(simulation->frame()->state) == hash);
}

TEST_CASE("each world and each episode of a batch has its own values", "[randomize]") {
  const auto model = scene("<randomize what=\"arm.a.mass\" by=\"uniform(0.5, 2)\"/>");
  BatchOptions options;
  options.backend = "cogrsim";
  options.seeds = {1, 2};
  options.duration = 0.05;
  options.auto_reset = true;
  auto batch = Batch::create(model, 2, options, loader());
  REQUIRE(batch);
  const auto mass = [&](int world) { return body(*(*batch)->world(world).model(), "arm.a").mass; };
  CHECK(mass(0) == body(*drawn(model, 1), "arm.a").mass);
  CHECK(mass(1) == body(*drawn(model, 2), "arm.a").mass);
  (*batch)->step(60);  // beyond the end: a new episode begins
  CHECK(mass(0) == body(*drawn(model, episode_seed(1, 1)), "arm.a").mass);
  CHECK(mass(1) == body(*drawn(model, episode_seed(2, 1)), "arm.a").mass);
}
