// A PID law for one joint.
#pragma once

namespace joint_pid {

/// Output u = kp e + ki I - kd v, clamped to +-limit, with the error e = target - position, its
/// integral I and the measured speed v. The derivative acts on the measurement and not on the
/// error, so that a step of the target causes no derivative kick.
///
/// There are two anti-windup measures: while the output is clamped, an error that would increase it
/// further is not integrated (conditional integration; Åström and Hägglund, Advanced PID Control,
/// 2006,
/// 3.5), and ki I alone never exceeds the limit.
class Pid {
 public:
  struct Gains {
    double kp = 0.0;     ///< output per coordinate
    double ki = 0.0;     ///< output per coordinate and second
    double kd = 0.0;     ///< output per speed
    double limit = 0.0;  ///< of the output, > 0, may be infinite
  };

  Pid() = default;
  explicit Pid(const Gains& gains) : gains_(gains) {}

  /// Computes the output from the `position` and `velocity` of the joint; `dt` is the time since
  /// the
/// previous update [s].
  double update(double target, double position, double velocity, double dt);
  /// The contribution ki I of the integral to the output.
  double integral_output() const { return integral_; }
  /// Restores the contribution of the integral.
  void set_integral_output(double value) { integral_ = value; }

 private:
  Gains gains_;
  double integral_ = 0.0;  // ki I
};

}  // namespace joint_pid
