// What a motor asks of the physics during one step.
#pragma once

#include <limits>

namespace cogrsim {

/// The law of one motor over one step, on one axis of one joint with coordinate q and speed u:
///
///     effort = clamp(bias + kp (position - q) + kd (velocity - u), -max_effort, +max_effort)
///
/// Every motor mode is an instance of it (see MotorMode and docs/concepts): a torque motor has only
/// `bias`, a servo kp, kd and the integral part as bias, a DC motor kd = kt ke / R. With
/// kd = infinity it is an ideal speed source: the effort is whatever within the bounds brings u to
/// `velocity` at the end of the step; kp and bias are then ignored. At a stop of the joint it pushes
/// with its bound; one without a bound is never asked to go beyond a stop.
///
/// A backend must not lose stability for any kp, kd >= 0: where they are stiff against the step it
/// integrates them implicitly. The clamp bounds the mean effort over the step (impulse / dt).
struct Drive {
  double bias = 0.0;      ///< [N m] or [N]
  double kp = 0.0;        ///< [N m/rad] or [N/m], >= 0
  double position = 0.0;  ///< [rad] or [m]
  double kd = 0.0;        ///< [N m s/rad] or [N s/m], >= 0, may be infinite
  double velocity = 0.0;  ///< [rad/s] or [m/s]
  double max_effort = std::numeric_limits<double>::infinity();  ///< >= 0

  bool is_speed_source() const { return kd == std::numeric_limits<double>::infinity(); }
};

}  // namespace cogrsim
