// The control law of a motor during one step.
#pragma once

#include <limits>

namespace cogrsim {

/// Control law of one motor over one step, on a joint axis with the coordinate q and the speed u:
///
///     effort = clamp(bias + kp (position - q) + kd (velocity - u), -max_effort, +max_effort)
///
/// Every motor mode is a special case (see MotorMode and docs/guide/concepts.md): a torque motor
/// has only `bias`; a servo has kp, kd and the integral part as bias; a DC motor has kd = kt ke /
/// R. With kd = infinity the motor is an ideal speed source: it exerts the effort within the limits
/// that brings u to `velocity` at the end of the step, and kp and bias are ignored. At a joint
/// limit it exerts its maximum effort; a motor without an effort limit never gets a velocity beyond
/// a joint limit.
///
/// A backend must be stable for all kp, kd >= 0: it integrates gains implicitly if they are stiff
/// relative to the time step. The clamp limits the mean effort over the step (impulse / dt).
struct Drive {
  double bias = 0.0;      ///< [N m] or [N]
  double kp = 0.0;        ///< [N m/rad] or [N/m], >= 0
  double position = 0.0;  ///< [rad] or [m]
  double kd = 0.0;        ///< [N m s/rad] or [N s/m], >= 0, may be infinite
  double velocity = 0.0;  ///< [rad/s] or [m/s]
  double max_effort = std::numeric_limits<double>::infinity();  ///< [N m] or [N], >= 0

  bool is_speed_source() const { return kd == std::numeric_limits<double>::infinity(); }
};

}  // namespace cogrsim
