// A PID law for one joint.
#pragma once

namespace joint_pid {

/// Output u = kp e + ki I - kd v, clamped to +-limit, with the error e = target - position, its
/// integral I and the measured speed v. The derivative acts on the measurement, not on the error,
/// so a jump of the target does not kick.
///
/// Anti-windup, twofold: while the output is clamped, an error that would push it further out is
/// not integrated (conditional integration; Åström and Hägglund, Advanced PID Control, 2006, 3.5),
/// and ki I alone never exceeds the limit.
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

  /// `position` and `velocity` of the joint, `dt` since the update before [s].
  double update(double target, double position, double velocity, double dt);
  /// ki I: what the integral contributes to the output.
  double integral_output() const { return integral_; }
  /// Goes on with the integral of another time.
  void set_integral_output(double value) { integral_ = value; }

 private:
  Gains gains_;
  double integral_ = 0.0;  // ki I
};

}  // namespace joint_pid
