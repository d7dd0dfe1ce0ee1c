// Motor modes end to end, against closed forms on a flywheel of 0.02 kg m^2.
#include <cmath>

#include "../support/temporary_folder.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/simulation/snapshot_file.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

double speed_of(Simulation& s) { return s.frame()->state.joint_velocities[0]; }
double angle_of(Simulation& s) { return s.frame()->state.joint_positions[0]; }

}  // namespace

TEST_CASE("a torque motor accelerates evenly up to its speed limit", "[motors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::torque);
  scene.builder.model.motors[0].target = 0.1;
  scene.builder.model.motors[0].max_speed = 2.0;
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(0.2);
  CHECK(speed_of(*simulation) == Approx(0.1 / Flywheel::kInertia * 0.2).epsilon(1e-6));
  simulation->run_until(1.0);
  CHECK(speed_of(*simulation) == Approx(2.0).epsilon(1e-9));
}

TEST_CASE("a position motor approaches at its speed limit, then exponentially", "[motors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::position);
  scene.builder.model.motors[0].target = 1.0;
  scene.builder.model.motors[0].max_speed = 2.0;
  scene.builder.model.motors[0].response = 0.1;
  auto simulation = simulate(scene.builder.build(), backend);
  // At 2 rad/s until 2 * 0.1 rad are left, at 0.4 s; then 0.2 exp(-(t - 0.4) / 0.1).
  simulation->run_until(0.3);
  CHECK(angle_of(*simulation) == Approx(0.6).margin(5e-3));
  simulation->run_until(0.6);
  CHECK(angle_of(*simulation) == Approx(1.0 - 0.2 * std::exp(-2.0)).margin(5e-3));
}

TEST_CASE("a DC motor runs up to its no-load speed with its own time constant", "[motors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::dc);
  Motor& motor = scene.builder.model.motors[0];
  motor.kt = motor.ke = 0.05;
  motor.resistance = 0.5;
  motor.gear = 3.0;
  motor.target = 6.0;
  motor.max_voltage = 3.0;  // clamps the requested 6 V
  auto simulation = simulate(scene.builder.build(), backend);
  // gear^2 kt ke / R = 0.045 N m s/rad; tau = I / 0.045 = 0.444 s; no-load 3 V / (ke gear) = 20
  // rad/s.
  const double tau = Flywheel::kInertia / 0.045;
  simulation->run_until(tau);
  CHECK(speed_of(*simulation) == Approx(20.0 * (1.0 - std::exp(-1.0))).epsilon(5e-3));
}

TEST_CASE("the integral of a servo removes the error a load leaves", "[motors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::servo);
  Motor& motor = scene.builder.model.motors[0];
  motor.kp = 2.0;
  motor.kd = 0.3;
  motor.ki = GENERATE(0.0, 4.0);
  motor.target = 0.5;
  const double ki = motor.ki;
  const int load = scene.builder.motor("bot.load", scene.joint, MotorMode::torque);
  scene.builder.model.motors[load].target = -0.4;
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(8.0);
  const double expected = ki > 0.0 ? 0.5 : 0.5 - 0.4 / 2.0;
  CHECK(angle_of(*simulation) == Approx(expected).margin(1e-3));
}

TEST_CASE("a velocity motor with and without a bound stays at a stop", "[motors]") {
  const std::string backend = GENERATE("bullet", "cogrsim", "ode");
  const double bound = GENERATE(0.3, std::numeric_limits<double>::infinity());
  INFO(backend << " " << bound);
  Flywheel scene(MotorMode::velocity);
  Motor& motor = scene.builder.model.motors[0];
  motor.target = 2.0;
  motor.max_effort = bound;
  scene.builder.model.joints[scene.joint].axes[0].upper = 0.5;
  auto simulation = simulate(scene.builder.build(), backend);
  simulation->run_until(1.0);
  // The joint reaches its stop within one step, and stays within 1e-6 of it.
  CHECK(angle_of(*simulation) == Approx(0.5).margin(1e-6));
  CHECK(speed_of(*simulation) == Approx(0.0).margin(1e-6));
  // Motor and stop cancel. How a source without a bound shares the effort with the stop is not
  // determined; sources with a bound are tested by the conformance suite.
  CHECK(simulation->frame()->state.joint_efforts[0] == Approx(0.0).margin(1e-6));
}

TEST_CASE("a motor follows a signal over time until something sets its target", "[motors]") {
  const std::string backend = GENERATE(engines());
  Flywheel scene(MotorMode::velocity);
  scene.builder.model.motors[0].target_signal = "0.5 rad/s * cos(pi * time / 1 s)";
  const auto model = scene.builder.build();
  auto simulation = simulate(model, backend);
  simulation->run_until(0.5);
  const int steps = static_cast<int>(simulation->step_count());
  // The speed of step k is the signal at its begin k dt: the angle is
  // dt sum 0.5 cos(pi k dt) = 0.25 dt (1 + sin(pi (n - 1/2) dt) / sin(pi dt / 2)). A method that takes
  // the mean of the speeds before and after a step differs by half of dt times the last speed.
  const double dt = simulation->dt();
  const double angle =
      0.25 * dt * (1.0 + std::sin(kPi * (steps - 0.5) * dt) / std::sin(0.5 * kPi * dt));
  // Other engines' speed sources may lag by a step, in which the speed changes by 0.5 pi dt.
  const double rounding = states_figures(backend) ? 1e-9 : 0.5 * kPi * dt;
  CHECK(angle_of(*simulation) == Approx(angle).margin(0.25 * dt + rounding));
  CHECK(speed_of(*simulation) == Approx(0.5 * std::cos(kPi * (steps - 1) * dt)).margin(rounding));

  const std::uint64_t hash = state_hash(simulation->frame()->state);
  simulation->send(SetMotor{"bot.left", 0.1});
  simulation->run_until(1.0);
  CHECK(speed_of(*simulation) == Approx(0.1).margin(rounding));
  simulation->send(Restart{});  // the signal counts again
  simulation->step();
  simulation->run_until(0.5);
  CHECK(state_hash(simulation->frame()->state) == hash);
}

TEST_CASE("a resumed run has the targets of the signal, or that of the command", "[motors]") {
  SimulationOptions options;
  options.backend = GENERATE(engines());
  const bool commanded = GENERATE(false, true);
  Flywheel scene(MotorMode::position);
  scene.builder.model.motors[0].target_signal = "0.3 rad * sin(2 rad/s * time)";
  const SceneModelPtr model = scene.builder.build();
  auto simulation = simulate(model, options.backend);
  if (commanded) simulation->send(SetMotor{"bot.left", 0.2});
  simulation->run_until(0.4);
  const SimulationSnapshotPtr saved = simulation->save();
  const TemporaryFolder folder;
  REQUIRE(write_snapshot(*simulation, folder / "wheel.snap"));
  simulation->run_until(0.8);
  const double angle = angle_of(*simulation);
  CHECK((std::abs(simulation->frame()->state.joint_velocities[0]) > 0.01) == !commanded);

  const auto file = SnapshotFile::read(folder / "wheel.snap");
  REQUIRE(file);
  auto resumed = resume(*file, model, options, loader());
  REQUIRE(resumed);
  resumed->simulation->run_until(0.8);
  // A file has the state as it is read, not the engine's own numbers.
  CHECK(angle_of(*resumed->simulation) == Approx(angle).margin(1e-9));

  REQUIRE(simulation->restore(saved));
  simulation->run_until(0.8);
  CHECK(angle_of(*simulation) == angle);
}
