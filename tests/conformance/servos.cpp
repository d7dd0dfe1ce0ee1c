// Servos and DC motors on every axis, against their step responses.
#include <Eigen/Eigenvalues>
#include <complex>

#include "axis_rig.h"
#include "generated_tests.h"

namespace conformance {
namespace {

constexpr double kStepResponse = 5e-3;  // of the step, the table's figure

Drive servo(double kp, double target, double kd, double max_effort = kInfinity) {
  Drive drive;
  drive.kp = kp;
  drive.position = target;
  drive.kd = kd;
  drive.max_effort = max_effort;
  return drive;
}

// Solution of x' = A x from x0 at t, by the eigenvectors of A (all eigenvalues distinct).
class LinearMotion {
 public:
  LinearMotion(const Eigen::MatrixXd& A, const Eigen::VectorXd& x0)
      : solver_(A),
        weights_(solver_.eigenvectors().fullPivLu().solve(x0.cast<std::complex<double>>().eval())) {
  }
  Eigen::VectorXd at(double t) const {
    const Eigen::VectorXcd modes = (solver_.eigenvalues() * t).array().exp() * weights_.array();
    return (solver_.eigenvectors() * modes).real();
  }

 private:
  Eigen::EigenSolver<Eigen::MatrixXd> solver_;
  Eigen::VectorXcd weights_;
};

// I q'' = kp (target - q) - kd q': with x = (q - target, q').
void pd(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::servo);
  Sim sim(rig.builder);
  const double w = 5.0, damping_ratio = 0.6, target = 0.4;
  sim.drive(motor) = servo(w * w * rig.inertia, target, 2.0 * damping_ratio * w * rig.inertia);
  Eigen::Matrix2d A;
  A << 0, 1, -w * w, -2.0 * damping_ratio * w;
  const LinearMotion motion(A, Eigen::Vector2d(-target, 0));
  Worst coordinate;
  double t = 0.0;
  sim.run(2.0, kDt, [&] {
    t += kDt;
    coordinate.see(rig.q(sim), target + motion.at(t)[0]);
  });
  measure("position error over the step", coordinate.error / target, kStepResponse);
}

// A constant load is taken up by the integral, which the caller adds as bias:
// x = (q - target, q', integral of target - q).
void pid(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::servo);
  const int load = rig.builder.motor("load", rig.joint, MotorMode::torque, kind.axis);
  Sim sim(rig.builder);
  const double w = 5.0, target = 0.4, pull = -1.0;  // [rad/s^2] or [m/s^2]
  const double kp = 3.0 * w * w, kd = 3.0 * w, ki = 1.2 * w * w * w;
  sim.drive(load) = constant_effort(pull * rig.inertia);
  // x' = A x + b becomes homogeneous with a constant fourth component.
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A.row(0) << 0, 1, 0, 0;
  A.row(1) << -kp, -kd, ki, pull;
  A.row(2) << -1, 0, 0, 0;
  const LinearMotion motion(A, Eigen::Vector4d(-target, 0, 0, 1));
  Worst coordinate;
  double t = 0.0, integral = 0.0;
  sim.drive(motor) = servo(kp * rig.inertia, target, kd * rig.inertia);
  sim.run(3.0, kDt, [&] {
    t += kDt;
    coordinate.see(rig.q(sim), target + motion.at(t)[0]);
    integral += (target - rig.q(sim)) * kDt;
    sim.drive(motor).bias = ki * rig.inertia * integral;
  });
  measure("position error over the step", coordinate.error / target, kStepResponse);
  measure("offset left by the load over the step", std::abs(rig.q(sim) - target) / target,
          kStepResponse);
}

// Far from its target it gives its bound: e t / I. Then it creeps in with kd / kp = 0.6 s, which
// six seconds reduce to less than 1e-4 of the step.
void saturated(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::servo);
  Sim sim(rig.builder);
  const double bound = 2.0 * rig.inertia, target = 3.0;
  sim.drive(motor) = servo(100.0 * rig.inertia, target, 60.0 * rig.inertia, bound);
  double largest = 0.0, t = 0.0;
  Worst speed;
  sim.run(0.8, kDt, [&] {
    t += kDt;
    largest = std::max(largest, std::abs(sim.motor_effort(motor)) / bound);
    speed.see(rig.u(sim), 2.0 * t);
  });
  measure("speed error while saturated, relative", speed.error / (2.0 * 0.8), kStepResponse);
  sim.run(6.0, kDt,
          [&] { largest = std::max(largest, std::abs(sim.motor_effort(motor)) / bound); });
  measure("effort over its bound, less 1", largest - 1.0, 1e-9);
  measure("position error at the end over the step", std::abs(rig.q(sim) - target) / target,
          kStepResponse);
}

// Gains a thousand times beyond what an explicit method could take at this step stay stable.
void stiff(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::servo);
  Sim sim(rig.builder);
  const double target = 0.3;
  sim.drive(motor) = servo(1e9 * rig.inertia, target, 1e6 * rig.inertia);
  double highest = 0.0;
  sim.run(1.0, kDt, [&] { highest = std::max(highest, rig.q(sim)); });
  measure("overshoot over the step", highest / target - 1.0, kStepResponse);
  measure("position error at the end over the step", std::abs(rig.q(sim) - target) / target,
          kStepResponse);
}

// A brushed motor with gear: effort = gear kt (V - ke gear u) / R, so that I u' + D u = gear kt V /
// R with D = gear^2 kt ke / R; u = V / (ke gear) (1 - exp(-D t / I)).
void dc(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::dc);
  Sim sim(rig.builder);
  const double kt = 0.05, ke = 0.05, gear = 10.0, voltage = 1.0;
  const double tau = 0.25;  // [s], the resistance is chosen for it
  const double resistance = gear * gear * kt * ke * tau / rig.inertia;
  sim.drive(motor) = constant_effort(gear * kt * voltage / resistance);
  sim.drive(motor).kd = gear * gear * kt * ke / resistance;
  const double final_speed = voltage / (ke * gear);
  Worst speed;
  double t = 0.0;
  sim.run(2.0, kDt, [&] {
    t += kDt;
    speed.see(rig.u(sim), final_speed * (1.0 - std::exp(-t / tau)));
  });
  // Implicit Euler errs by 0.37 dt / 2 tau < 1e-3 of the step.
  measure("speed error over the step", speed.error / final_speed, kStepResponse);
  measure_relative("way", rig.q(sim), final_speed * (t - tau * (1.0 - std::exp(-t / tau))),
                   kStepResponse);
}

// The current's bound is a bound of the effort: a ramp, then the exponential.
void dc_bounded(const AxisKind& kind) {
  AxisRig rig(kind);
  const int motor = rig.motor(MotorMode::dc);
  Sim sim(rig.builder);
  const double rate = 4.0, final_speed = 2.0, acceleration = 3.0;  // D / I, V / ke, bound / I
  sim.drive(motor) = constant_effort(rate * final_speed * rig.inertia);
  sim.drive(motor).kd = rate * rig.inertia;
  sim.drive(motor).max_effort = acceleration * rig.inertia;
  // The bound lets go where rate (final - u) = acceleration.
  const double free_speed = final_speed - acceleration / rate;
  const double free_time = free_speed / acceleration;
  Worst speed;
  double t = 0.0, largest = 0.0;
  sim.run(2.0, kDt, [&] {
    t += kDt;
    largest = std::max(largest, sim.motor_effort(motor) / (acceleration * rig.inertia));
    speed.see(rig.u(sim), t < free_time ? acceleration * t
                                        : final_speed - (final_speed - free_speed) *
                                                            std::exp(-rate * (t - free_time)));
  });
  measure("speed error over the step", speed.error / final_speed, kStepResponse);
  measure("effort over its bound, less 1", largest - 1.0, 1e-9);
}

}  // namespace

std::vector<GeneratedTest> servo_tests() {
  std::vector<GeneratedTest> tests;
  for (const AxisKind& kind : axis_kinds()) {
    if (kind.type == JointType::ball) continue;  // a motor turns one axis
    const std::string name = "motor on " + kind.name + ": ";
    const auto add = [&](const std::string& what, void (*run)(const AxisKind&)) {
      tests.push_back({name + what, "[motors]", [kind, run] { run(kind); }});
    };
    add("servo PD", pd);
    add("servo PID under load", pid);
    add("servo, saturated", saturated);
    add("servo, stiff", stiff);
    add("dc", dc);
    add("dc, bounded", dc_bounded);
  }
  return tests;
}

}  // namespace conformance
