// Every axis of every joint type without a motor: coasting, spring, damping, friction.
#include "axis_rig.h"
#include "generated_tests.h"

namespace conformance {
namespace {

// q = u0 t, and the joint's other freedoms stay where they are.
void coast(const AxisKind& kind) {
  AxisRig rig(kind);
  const double u0 = 1.3;
  rig.start_speed(u0);
  Sim sim(rig.builder);
  Worst speed, coordinate;
  double t = 0.0, gap = 0.0, tilt = 0.0;
  sim.run(2.0, kDt, [&] {
    t += kDt;
    speed.see(rig.u(sim), u0);
    coordinate.see(rig.q(sim),
                   kind.type == JointType::ball ? std::remainder(u0 * t, 2 * kPi) : u0 * t);
    const Joint& joint = sim.model().joints[0];
    const JointError error = joint_error(joint, relative_pose(joint, Pose(), sim.pose(rig.body)));
    gap = std::max(gap, error.distance);
    tilt = std::max(tilt, error.angle);
  });
  // Nothing acts: only the constraint's own error, for which the loop's figure is taken.
  measure("speed error, relative", speed.error / u0, 1e-4);
  measure("coordinate error, relative to the way", coordinate.error / (u0 * t), 1e-4);
  measure("gap [m]", gap, 1e-4);
  measure("tilt [rad]", tilt, 1e-4);
  // A coordinate that belongs to the pose: what the body really did.
  const Joint& joint = sim.model().joints[0];
  std::vector<double> q(static_cast<std::size_t>(position_count(kind.type)));
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = sim.q(0, static_cast<int>(i));
  const Pose expected = joint.X_PF * joint_pose(joint, q.data()) * joint.X_CM.inverse();
  measure("pose against coordinates [m]", (expected.p - sim.pose(rig.body).p).norm(), 1e-4);
}

// q = rest (1 - cos w t) + u0 / w sin w t. The rest of a ball's spring is always q = 0.
void spring(const AxisKind& kind) {
  AxisRig rig(kind);
  const double w = 2.0 * kPi, u0 = 1.0;
  const double rest = kind.type == JointType::ball ? 0.0 : 0.2;
  const double stiffness = rig.inertia * w * w;  // the builder is spent once the world is made
  rig.axis().stiffness = stiffness;
  rig.axis().rest = rest;
  rig.start_speed(u0);
  Sim sim(rig.builder);
  Worst coordinate;
  double t = 0.0;
  sim.run(3.0, kDt, [&] {
    t += kDt;
    coordinate.see(rig.q(sim), rest * (1.0 - std::cos(w * t)) + u0 / w * std::sin(w * t));
  });
  // First-order methods are out of phase by w dt / 2 and as much again in the velocity: w dt.
  measure("coordinate error over amplitude", coordinate.error / std::hypot(rest, u0 / w), 1e-2);
  measure("effort error over the spring's largest",
          std::abs(rig.effort(sim) + stiffness * (rig.q(sim) - rest)) /
              (stiffness * std::hypot(rest, u0 / w)),
          1e-2);
}

// A damper that stops the axis within a fiftieth of a step, and gives way to a load at load / damping.
void stiff_damping(const AxisKind& kind) {
  AxisRig rig(kind);
  const double u0 = 1.0, c = 50.0 * rig.inertia / kDt;
  rig.axis().damping = c;
  rig.start_speed(u0);
  const int motor = kind.type == JointType::ball ? -1 : rig.motor(MotorMode::torque);
  Sim sim(rig.builder);
  sim.run(0.1);
  // A step at the whole speed is what the end of the first step comes too late for, at most.
  measure("way after stiff damping, in steps", std::abs(rig.q(sim)) / (u0 * kDt), 1.0);
  measure("speed after stiff damping", std::abs(rig.u(sim)), 1e-6);
  if (motor < 0) return;
  sim.drive(motor) = constant_effort(0.1 * c);
  sim.run(0.1);
  measure_relative("speed under a load", rig.u(sim), 0.1, 1e-3);
}

// u = u0 exp(-c t / I).
void damping(const AxisKind& kind) {
  AxisRig rig(kind);
  const double rate = 2.0, u0 = 1.0;
  rig.axis().damping = rig.inertia * rate;
  rig.start_speed(u0);
  Sim sim(rig.builder);
  Worst speed;
  double t = 0.0;
  sim.run(1.5, kDt, [&] {
    t += kDt;
    speed.see(rig.u(sim), u0 * std::exp(-rate * t));
  });
  // Euler's speed errs by (rate t) exp(-rate t) rate dt / 2 < 0.37 rate dt / 2.
  measure("speed error over u0", speed.error / u0, 0.5 * rate * kDt);
  measure_relative("way", rig.q(sim), u0 / rate * (1.0 - std::exp(-rate * t)), 5e-3);
  stiff_damping(kind);
}

// Slows down at f / I, then stands still.
void friction(const AxisKind& kind) {
  AxisRig rig(kind);
  const double deceleration = 2.0, u0 = 1.0;
  const double held = rig.inertia * deceleration;
  rig.axis().friction = held;
  rig.start_speed(u0);
  Sim sim(rig.builder);
  Worst speed, effort;
  double t = 0.0;
  sim.run(0.5, kDt, [&] {
    t += kDt;
    speed.see(rig.u(sim), u0 - deceleration * t);
    if (t < 0.4) effort.see(rig.effort(sim), -held);
  });
  // Constant deceleration is exact for any method but for the step in which it ends.
  measure("speed error over u0", speed.error / u0, deceleration * kDt);
  measure("effort error over the friction", effort.error / held, 1e-3);
  measure_relative("way", rig.q(sim), 0.5 * u0 * u0 / deceleration, 5e-3);
  const double stopped = rig.q(sim);
  sim.run(1.0);
  measure("creep after the stop", std::abs(rig.q(sim) - stopped), 1e-4);
}

// Nothing moves below the friction; above it the excess accelerates.
void friction_under_load(const AxisKind& kind) {
  AxisRig rig(kind);
  rig.axis().friction = rig.inertia;
  const int motor = rig.motor(MotorMode::torque);
  Sim sim(rig.builder);
  sim.drive(motor) = constant_effort(0.9 * rig.inertia);
  sim.run(1.0);
  measure("creep under 0.9 of the friction", std::abs(rig.q(sim)), 1e-4);
  sim.drive(motor) = constant_effort(-1.5 * rig.inertia);
  const double before = rig.u(sim);
  sim.run(1.0);
  measure_relative("acceleration under 1.5 of the friction", rig.u(sim) - before, -0.5, 5e-3);
}

}  // namespace

std::vector<GeneratedTest> axis_tests() {
  std::vector<GeneratedTest> tests;
  for (const AxisKind& kind : axis_kinds()) {
    const std::string name = "joint axis " + kind.name + ": ";
    const auto add = [&](const std::string& what, void (*run)(const AxisKind&)) {
      tests.push_back({name + what, "[joints]", [kind, run] { run(kind); }});
    };
    add("coasts", coast);
    add("spring", spring);
    add("damping", damping);
    add("friction", friction);
    if (kind.type != JointType::ball) add("friction under load", friction_under_load);
  }
  return tests;
}

}  // namespace conformance
