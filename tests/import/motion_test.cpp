// Imported models move as their sources say, on every engine: closed forms.
#include <cmath>

#include "../support/engines.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/simulation/simulation.h"
#include "import_support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

/// The last frame of a run.
FramePtr run(const SceneModelPtr& model, const std::string& engine, double seconds) {
  static const auto kLoader = std::make_shared<PluginLoader>();
  SimulationOptions options;
  options.backend = engine;
  auto simulation = Simulation::create(model, options, kLoader);
  if (!simulation) INFO(simulation.error().front().message);
  REQUIRE(simulation);
  REQUIRE((*simulation)->run_until(seconds) == RunStatus::completed);
  return (*simulation)->frame();
}

const Pose& pose_of(const Frame& frame, const std::string& body) {
  const std::string tail = "." + body;
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) {
    const std::string& name = frame.model->bodies[i].name;
    if (name.size() > tail.size() &&
        name.compare(name.size() - tail.size(), tail.size(), tail) == 0)
      return frame.state.poses[i];
  }
  FAIL("no body " + body);
  return frame.state.poses.front();
}

/// Way along x in 1 s of what is pulled by `pull` [m/s^2] and rubs with `mu`.
double slide(double mu, double pull) { return 0.5 * std::max(0.0, pull - mu * 9.81); }

// Engines settle a box by up to a millimetre, sample the way by v dt / 2 = 2.5 mm and less, creep by at
// most 1 cm/s where it should hold (Simbody's transition velocity), and MuJoCo's soft friction lags by
// some 0.5 % of the way. Another rule of combination is off by more than 0.1 m.
constexpr double kSlideBound = 0.02;

struct Pair {
  const char *floor, *puck, *contact;
  double pull, mu;
};

}  // namespace

TEST_CASE("pairs of geoms have the friction that MuJoCo gives them", "[mjcf][motion]") {
  const Pair pair = GENERATE(
      // Frictionless by condim, on both.
      Pair{R"(condim="1")", R"(condim="1")", "", 3.0, 0.0},
      // The larger condim and the larger friction, also that of the geom with condim 1.
      Pair{R"(condim="3" friction="0.1")", R"(condim="1" friction="0.3")", "", 5.0, 0.3},
      // The larger friction.
      Pair{R"(friction="0.1")", R"(friction="0.8")", "", 4.0, 0.8},
      Pair{R"(friction="0.1")", R"(friction="0.3")", "", 5.0, 0.3},
      // All of the geom with the higher priority.
      Pair{R"(friction="0.2" priority="1")", R"(friction="0.9")", "", 5.0, 0.2},
      Pair{R"(friction="0.9" priority="1")", R"(friction="0.2" priority="2")", "", 5.0, 0.2},
      Pair{R"(friction="0.9")", R"(condim="1" priority="1")", "", 3.0, 0.0},
      // Those of the pair.
      Pair{R"(friction="0.9" name="f")", R"(friction="0.8" name="p")",
           R"(<pair geom1="f" geom2="p" friction="0.3 0.3 0.005 0.0001 0.0001"/>)", 5.0, 0.3},
      Pair{R"(friction="0.9" name="f")", R"(friction="0.8" name="p")",
           R"(<pair geom1="f" geom2="p" condim="1"/>)", 3.0, 0.0});
  const std::string engine = GENERATE(engines());
  Imported in;
  dsl::LoaderCatalog catalog;  // of the priority that materials have on one engine
  in.plugins = &catalog;
  in.read("<mujoco model=\"m\"><option timestep=\"0.001\" gravity=\"" + std::to_string(pair.pull) +
              " 0 -9.81\"/><worldbody><geom type=\"plane\" size=\"50 50 1\" " + pair.floor +
              "/><body name=\"puck\" pos=\"0 0 0.05\"><freejoint/><geom type=\"box\" "
              "size=\"0.1 0.1 0.05\" mass=\"1\" " +
              pair.puck + "/></body></worldbody><contact>" + pair.contact + "</contact></mujoco>",
          "m.xml");
  REQUIRE(in.model);
  INFO(engine << "\n" << in.result.scene);
  CHECK(pose_of(*run(in.model, engine, 1.0), "puck").p.x() ==
        Approx(slide(pair.mu, pair.pull)).margin(kSlideBound));
}

TEST_CASE("pairs of collisions have the smaller friction, as in Gazebo", "[sdf][motion]") {
  const auto [floor, puck, mu] = GENERATE(std::tuple{0.1, 0.9, 0.1}, std::tuple{0.9, 0.1, 0.1},
                                          std::tuple{0.1, -1.0, 0.1});  // 1 where none is given
  const std::string engine = GENERATE(engines());
  const auto surface = [](double of) {
    if (of < 0.0) return std::string();
    const std::string text = std::to_string(of);
    return "<surface><friction><ode><mu>" + text + "</mu><mu2>" + text +
           "</mu2></ode></friction></surface>";
  };
  Imported in;
  in.read(
      "<sdf version=\"1.9\"><world name=\"w\"><gravity>2 0 -9.81</gravity>"
      "<physics name=\"p\" type=\"ode\"><max_step_size>0.001</max_step_size></physics>"
      "<model name=\"ground\"><static>true</static><link name=\"l\"><collision name=\"c\">"
      "<geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>" +
          surface(floor) +
          "</collision></link></model><model name=\"puck\"><pose>0 0 0.05 0 0 0</pose>"
          "<link name=\"block\"><inertial><mass>1</mass><inertia><ixx>0.004</ixx><iyy>0.004"
          "</iyy><izz>0.007</izz></inertia></inertial><collision name=\"c\"><geometry><box>"
          "<size>0.2 0.2 0.1</size></box></geometry>" +
          surface(puck) + "</collision></link></model></world></sdf>",
      "w.sdf");
  REQUIRE(in.model);
  INFO(engine << "\n" << in.result.scene);
  const FramePtr end = run(in.model, engine, 1.0);
  double x = 0.0;
  for (std::size_t i = 0; i < in.model->bodies.size(); ++i)
    if (in.model->bodies[i].kind == BodyKind::dynamic) x = end->state.poses[i].p.x();
  CHECK(x == Approx(slide(mu, 2.0)).margin(kSlideBound));
}

TEST_CASE("damping and armature of a free joint act", "[mjcf][motion]") {
  // (m + a) v' = -m g - d v with m = a = 1, d = 2: v = -g/2 (1 - exp(-t)). A step errs by half of it in
  // the first-order law of the drag: g/2 dt/2 t.
  const std::string engine = GENERATE(engines());
  Imported in;
  in.read(
      R"(<mujoco model="m"><option timestep="0.001"/><default><joint damping="2" armature="1"/></default>
    <worldbody><body name="crate" pos="0 0 3"><joint name="root" type="free"/>
    <geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <body name="other" pos="5 0 3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    </worldbody></mujoco>)",
      "m.xml");
  REQUIRE(in.model);
  const double t = 0.6, g = 9.81;
  const FramePtr end = run(in.model, engine, t);
  CHECK(pose_of(*end, "crate").p.z() ==
        Approx(3.0 - 0.5 * g * (t - 1.0 + std::exp(-t))).margin(2e-3));
  // Classes say nothing of a <freejoint>.
  CHECK(pose_of(*end, "other").p.z() == Approx(3.0 - 0.5 * g * t * t).margin(4e-3));
}

TEST_CASE("a motor turns a ball joint about its gear", "[mjcf][motion]") {
  // 0.05 N m on 3 kg (0.2 m)^2 / 6 = 0.02 kg m^2 for 1 s.
  Imported in;
  in.read(R"(<mujoco model="m"><option timestep="0.001" gravity="0 0 0"/><worldbody>
    <body name="rotor" pos="0 0 1"><joint name="socket" type="ball"/>
    <geom type="box" size="0.1 0.1 0.1" mass="3"/></body></worldbody>
    <actuator><motor name="about_y" joint="socket" gear="0 2 0"/>
    <motor name="about_z" joint="socket" gear="0 0 -1"/></actuator></mujoco>)",
          "m.xml");
  REQUIRE(in.model);
  CHECK(in.reports(kApproximate, "joint 'socket'", "is a gimbal"));
  REQUIRE(in.model->motors.size() == 2);
  const auto [motor, torque, axis] =
      GENERATE(std::tuple{0, 0.05, Vec3(0, 1, 0)}, std::tuple{1, -0.05, Vec3(0, 0, 1)});
  auto driven = std::make_shared<SceneModel>(*in.model);
  // Its control u is 2 u, or -u, about the axis of the scene.
  driven->motors[std::size_t(motor)].target = torque;
  const FramePtr end = run(driven, "cogrsim", 1.0);
  const Vec3 w = end->state.twists.back().angular;
  CHECK(std::abs(w.dot(axis)) == Approx(2.5).epsilon(1e-3));
  CHECK((w - w.dot(axis) * axis).norm() < 1e-6);
}
