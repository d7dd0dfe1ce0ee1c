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

TEST_CASE("an exploding scene ends as diverged, with body and time", "[faults]") {
  const std::string backend = GENERATE(engines());
  auto builder = falling_ball();
  builder.model.bodies[0].V_WB.linear = Vec3(2e10, 0, 0);
  auto simulation = simulate(builder.build(), backend);
  CHECK(simulation->run_until(1.0) == RunStatus::diverged);
  CHECK(messages_of(*simulation).find("'ball'") != std::string::npos);
  CHECK(std::isfinite(simulation->frame()->state.poses[0].p.x()));
}
