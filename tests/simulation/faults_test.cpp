// Misbehaving controllers are reported with robot, time and cause, and never crash the simulation.
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

TEST_CASE("mistakes of configure are load errors that list the available names", "[faults]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene;
  scene.add_controller("missing-devices");
  const std::string said = refusal(scene.builder.build(), backend);
  CHECK(said.find("there is no motor 'lfet'") != std::string::npos);
  CHECK(said.find("did you mean 'left'?") != std::string::npos);
  CHECK(said.find("there is no sensor 'nowhere'") != std::string::npos);
  CHECK(said.find("'encoder'") != std::string::npos);
  CHECK(said.find("parameter 'speed' is declared as number") != std::string::npos);
}

TEST_CASE("exceptions in configure are load errors", "[faults]") {
  Flywheel one;
  one.add_controller("throw-in-configure");
  CHECK(refusal(one.builder.build(), "bullet").find("no calibration file") != std::string::npos);
  Flywheel other;
  other.add_controller("throw-int-in-configure");
  CHECK(refusal(other.builder.build(), "bullet").find("not a std::exception") != std::string::npos);
}

TEST_CASE("an exception in update stops that controller or the run", "[faults]") {
  const std::string backend = GENERATE(engines());
  const auto policy = GENERATE(FaultPolicy::stop_controller, FaultPolicy::end_run);
  Flywheel scene;
  scene.add_controller("throw-in-update", 100.0, policy);
  auto simulation = simulate(scene.builder.build(), backend);
  const RunStatus end = simulation->run_until(0.2);
  const std::string said = messages_of(*simulation);
  CHECK(said.find("'probe_controller' of 'bot'") != std::string::npos);
  CHECK(said.find("cell 9 of 8") != std::string::npos);
  check_fault(*simulation, end, policy, 0.03);
}

TEST_CASE("not-a-number sent to a motor is a fault and never reaches the physics", "[faults]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene;
  scene.add_controller("nan");
  auto simulation = simulate(scene.builder.build(), backend);
  CHECK(simulation->run_until(0.1) == RunStatus::completed);
  CHECK(messages_of(*simulation).find("to motor 'bot.left'") != std::string::npos);
  CHECK(std::isfinite(simulation->frame()->state.joint_velocities[0]));
}

TEST_CASE("unknown plugins and bad parameters are refused with the available names", "[faults]") {
  Flywheel scene;
  scene.add_controller("drive");
  scene.builder.model.controllers[0].plugin = "probe_mnid";
  const std::string unknown = refusal(scene.builder.build(), "bullet");
  CHECK(unknown.find("CG0901") != std::string::npos);
  CHECK(unknown.find("probe_mnid") != std::string::npos);

  Flywheel out_of_range;
  out_of_range.add_controller("drive");
  out_of_range.builder.model.controllers[0].parameters["speed"] = 11.0;
  CHECK(refusal(out_of_range.builder.build(), "bullet").find("speed") != std::string::npos);

  Flywheel wrong_kind;
  wrong_kind.add_controller("drive");
  wrong_kind.builder.model.controllers[0].plugin = "probe_supervisor";
  wrong_kind.builder.model.controllers[0].parameters.clear();
  CHECK(refusal(wrong_kind.builder.build(), "bullet").find("CG0903") != std::string::npos);

  CHECK(refusal(falling_ball().build(), "bulet").find("bullet") != std::string::npos);
}

TEST_CASE("a spin that is too fast for the step is reported once", "[faults]") {
  const std::string backend = GENERATE(engines());
  for (const bool fast : {false, true}) {
    ModelBuilder builder("rotor");
    const int rotor = builder.cylinder("rotor", 0.1, 0.02, 1.0, Pose());
    builder.model.physics.gravity = Vec3::Zero();
    builder.model.bodies[rotor].V_WB.angular = Vec3(0, 0, fast ? 1000.0 : 100.0);
    auto simulation = simulate(builder.build(), backend);
    simulation->run_until(0.2);
    const auto& messages = simulation->messages();
    CHECK(std::count_if(messages.begin(), messages.end(), [](const RunMessage& message) {
            return message.message.find("'rotor' turns by") != std::string::npos;
          }) == (fast ? 1 : 0));
  }
}

TEST_CASE("a spin that a hit in the first step takes is reported", "[faults]") {
  const std::string backend = GENERATE(engines());
  ModelBuilder builder("coin");
  builder.plane("floor");
  const int coin =
      builder.box("coin", Vec3(0.1, 0.1, 0.1), 1.0, Pose(Vec3(0, 0, 0.05), Quat(1, 0, 0, 0)));
  builder.model.bodies[coin].V_WB.angular = Vec3(600.0, 0, 0);
  auto simulation = simulate(builder.build(), backend);
  simulation->step();
  const auto& messages = simulation->messages();
  CHECK(std::any_of(messages.begin(), messages.end(), [](const RunMessage& message) {
    return message.message.find("'coin' turns by") != std::string::npos;
  }));
}

TEST_CASE("what presses bodies into each other is reported once", "[faults]") {
  const std::string backend = GENERATE(engines());
  // A block on two cubes: a hundred thousand times their mass is more than sweeps or stops carry.
  for (const bool heavy : {false, true}) {
    ModelBuilder builder("press");
    builder.plane("floor");
    const double mass = heavy ? 100.0 : 1e-3;
    for (const double x : {-0.1, 0.1})
      builder.box(x < 0 ? "left" : "right", Vec3(0.02, 0.02, 0.02), 1e-3,
                  Pose(Vec3(x, 0, 0.01), Quat(1, 0, 0, 0)));
    builder.box("block", Vec3(0.4, 0.1, 0.1), mass, Pose(Vec3(0, 0, 0.07), Quat(1, 0, 0, 0)));
    auto simulation = simulate(builder.build(), backend);
    simulation->run_until(0.15);  // two looks, 64 steps apart
    const auto& messages = simulation->messages();
    const auto said =
        std::count_if(messages.begin(), messages.end(), [](const RunMessage& message) {
          return message.message.find("overlap by") != std::string::npos;
        });
    // An engine that carries it has nothing to say.
    const bool carried = simulation->frame()->state.poses[3].p.z() > 0.068;
    CHECK(said == (carried ? 0 : 1));
    CHECK((heavy || carried));
  }
}

TEST_CASE("a spring or drag that the step does not hold is reported", "[faults]") {
  const std::string backend = GENERATE(engines());
  // Two spheres of 10 g: h^2 k / m = 1 at 5000 N/m in steps of 1 ms, 2 h c / m = 1 at 5 N s/m.
  const auto said = [&](double stiffness, double damping, double drag) {
    ModelBuilder builder("spring");
    builder.model.physics.gravity = Vec3::Zero();
    const int a = builder.sphere("a", 0.01, 0.01, Pose());
    const int b = builder.sphere("b", 0.01, 0.01, Pose(Vec3(0.1, 0, 0), Quat(1, 0, 0, 0)));
    ForceModel spring;
    spring.kind = ForceModel::Kind::spring;
    spring.name = "tie";
    spring.body = a;
    spring.other = b;
    spring.length = 0.1;
    spring.stiffness = stiffness;
    spring.damping = damping;
    builder.model.forces.push_back(spring);
    ForceModel air;
    air.kind = ForceModel::Kind::drag;
    air.name = "air";
    air.body = a;
    air.linear = drag;
    builder.model.forces.push_back(air);
    const auto simulation = simulate(builder.build(), backend);
    std::string out;
    for (const RunMessage& m : simulation->messages()) out += m.message + "\n";
    return out;
  };
  CHECK(said(4900.0, 0.0, 4.9).find("too stiff") == std::string::npos);
  CHECK(said(5100.0, 0.0, 0.0).find("spring 'tie' is too stiff") != std::string::npos);
  CHECK(said(0.0, 2.6, 0.0).find("spring 'tie' is too stiff") != std::string::npos);
  CHECK(said(0.0, 0.0, 5.1).find("drag 'air' is too stiff") != std::string::npos);
}

TEST_CASE("an exploding scene ends as diverged, with body and time", "[faults]") {
  const std::string backend = GENERATE(engines());
  auto builder = falling_ball();
  builder.model.bodies[0].V_WB.linear = Vec3(2e10, 0, 0);
  auto simulation = simulate(builder.build(), backend);
  CHECK(simulation->run_until(1.0) == RunStatus::diverged);
  CHECK(messages_of(*simulation).find("'ball'") != std::string::npos);
  CHECK(std::isfinite(simulation->frame()->state.poses[0].p.x()));
}
