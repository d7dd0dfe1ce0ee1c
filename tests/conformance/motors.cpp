// Torque, velocity and position motors on every axis, against their step responses.
#include "axis_rig.h"
#include "generated_tests.h"

namespace conformance {
namespace {

constexpr double kStepResponse = 5e-3;  // of the step, the table's figure

/// Largest effort a motor gave, over what it may give: the clamp bounds the mean over a step.
class Saturation {
 public:
  Saturation(Sim& sim, int motor, double max_effort)
      : sim_(sim), motor_(motor), max_effort_(max_effort) {}
  void look() { largest_ = std::max(largest_, std::abs(sim_.motor_effort(motor_)) / max_effort_); }
  void report() const { measure("effort over its bound, less 1", largest_ - 1.0, 1e-9); }

 private:
  Sim& sim_;
  int motor_;
  double max_effort_, largest_ = 0.0;
};

// u = e t / I, q = e t^2 / 2 I.
void torque(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::torque);
  Sim sim(rig.builder);
  const double acceleration = 3.0, seconds = 1.0;
  sim.drive(motor) = constant_effort(acceleration * rig.inertia);
  Worst speed, effort;
  double t = 0.0;
  sim.run(seconds, kDt, [&] {
    t += kDt;
    speed.see(rig.u(sim), acceleration * t);
    effort.see(sim.motor_effort(motor), acceleration * rig.inertia);
  });
  // A constant effort is exact in the speed; the displacement has the first-order bias a dt t / 2.
  measure("speed error, relative", speed.error / (acceleration * seconds), 1e-4);
  measure("way error, relative",
          std::abs(rig.q(sim) / (0.5 * acceleration * seconds * seconds) - 1.0),
          kDt / seconds + 1e-4);
  measure("reported motor effort, relative", effort.error / (acceleration * rig.inertia), 1e-9);
}

// The bias is clamped too.
void torque_bounded(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::torque);
  Sim sim(rig.builder);
  sim.drive(motor) = constant_effort(-50.0 * rig.inertia);
  sim.drive(motor).max_effort = 2.0 * rig.inertia;
  Saturation saturation(sim, motor, 2.0 * rig.inertia);
  sim.run(1.0, kDt, [&] { saturation.look(); });
  saturation.report();
  measure_relative("speed", rig.u(sim), -2.0, kStepResponse);
}

// An ideal speed source has its speed at the end of the first step.
void velocity(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::velocity);
  Sim sim(rig.builder);
  const double target = 2.0;
  sim.drive(motor) = speed_source(target);
  Worst speed;
  sim.run(1.0, kDt, [&] { speed.see(rig.u(sim), target); });
  measure("speed error over the target", speed.error / target, kStepResponse);
  measure_relative("way", rig.q(sim), target, kStepResponse);
  sim.drive(motor) = speed_source(-target);
  sim.step();
  measure("speed error after reversal over the target", std::abs(rig.u(sim) / target + 1.0),
          kStepResponse);
}

// With a bounded effort it is a ramp e t / I up to the target.
void velocity_bounded(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::velocity);
  Sim sim(rig.builder);
  const double target = 2.0, acceleration = 4.0, bound = acceleration * rig.inertia;
  sim.drive(motor) = speed_source(target, bound);
  Saturation saturation(sim, motor, bound);
  Worst speed;
  double t = 0.0;
  sim.run(1.0, kDt, [&] {
    t += kDt;
    saturation.look();
    speed.see(rig.u(sim), std::min(target, acceleration * t));
  });
  measure("speed error over the target", speed.error / target, kStepResponse);
  saturation.report();
}

// Two motors of which one pulls: the source holds its speed against half its bound, not against
// twice it.
void velocity_under_load(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::velocity);
  const int load = rig.builder.motor("load", rig.joint, MotorMode::torque, kind.axis);
  Sim sim(rig.builder);
  const double bound = 4.0 * rig.inertia, target = 1.0;
  sim.drive(motor) = speed_source(target, bound);
  Saturation saturation(sim, motor, bound);
  const auto look = [&] { saturation.look(); };
  sim.run(0.5, kDt, look);
  sim.drive(load) = constant_effort(-0.5 * bound);
  sim.run(0.5, kDt, look);
  measure("speed error under half the bound", std::abs(rig.u(sim) - target) / target,
          kStepResponse);
  measure_relative("effort under half the bound", sim.motor_effort(motor), 0.5 * bound,
                   kStepResponse);
  sim.drive(load) = constant_effort(-2.0 * bound);
  const double before = rig.u(sim);
  sim.run(0.5, kDt, look);
  measure_relative("deceleration under twice the bound", (rig.u(sim) - before) / 0.5, -4.0,
                   kStepResponse);
  saturation.report();
}

// A speed source whose speed is (target - q) / T: q = target (1 - exp(-t / T)).
void position(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::position);
  Sim sim(rig.builder);
  const double target = 0.5, response = 0.2;
  Worst coordinate;
  double t = 0.0;
  sim.drive(motor) = speed_source(target / response);
  sim.run(1.5, kDt, [&] {
    t += kDt;
    coordinate.see(rig.q(sim), target * (1.0 - std::exp(-t / response)));
    sim.drive(motor) = speed_source((target - rig.q(sim)) / response);
  });
  // Reading q once a step errs by 0.37 dt / 2 T < 1e-3 of the step.
  measure("position error over the step", coordinate.error / target, kStepResponse);
}

}  // namespace

std::vector<GeneratedTest> motor_tests() {
  std::vector<GeneratedTest> tests;
  for (const AxisKind& kind : axis_kinds()) {
    if (kind.type == JointType::ball) continue;  // a motor turns one axis
    const std::string name = "motor on " + kind.name + ": ";
    const auto add = [&](const std::string& what, void (*run)(const AxisKind&)) {
      tests.push_back({name + what, "[motors]", [kind, run] { run(kind); }});
    };
    add("torque", torque);
    add("torque, bounded", torque_bounded);
    add("velocity", velocity);
    add("velocity, bounded", velocity_bounded);
    add("velocity under load", velocity_under_load);
    add("position", position);
  }
  return tests;
}

}  // namespace conformance
