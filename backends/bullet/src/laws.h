// What acts along one axis of a joint, and how one step of it is handed to Bullet.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

namespace cogrsim::bullet {

inline constexpr double kUnbounded = 1e30;  ///< Bullet adds to and multiplies its bounds

/// A spring and damper with a bound: effort = clamp(bias + kp (position - q) + kd (velocity - u)).
///
/// Semi-implicit Euler holds it as an explicit effort while s = dt (kd + dt kp) / m stays below
/// about 2, m being the mass that the axis feels. Beyond, it becomes a motor of Bullet's: the law
/// taken at the end of the step,
///
///     effort = K (v - u+),  K = kd + dt kp,  v = (bias + kp (position - q) + kd velocity) / K,
///
/// is a speed source of v with the softness u+ = v - impulse / (K dt).
struct AxisLaw {
  double bias = 0.0, kp = 0.0, position = 0.0, kd = 0.0, velocity = 0.0;
  double bound = std::numeric_limits<double>::infinity();

  static AxisLaw of(const Drive& drive) {
    return {drive.bias, drive.kp, drive.position, drive.kd, drive.velocity, drive.max_effort};
  }
  static AxisLaw of(const JointAxis& axis) {
    return {
        0.0, axis.stiffness, axis.rest, axis.damping, 0.0, std::numeric_limits<double>::infinity()};
  }

  bool needs_state() const { return kp != 0.0 || kd != 0.0; }
  double gain(double dt) const { return kd + dt * kp; }
  /// Effort at coordinate q and speed u.
  double effort(double q, double u) const {
    const double wanted = bias + (kp != 0.0 ? kp * (position - q) : 0.0) + kd * (velocity - u);
    return std::clamp(wanted, -bound, bound);
  }
  double source(double q, double dt) const {
    return (bias + kp * (position - q) + kd * velocity) / gain(dt);
  }
};

/// s from which a law is a motor of Bullet's. Its sequential impulses converge for softnesses
/// below 1, by 1 / s per sweep: 3 % are left after 10.
inline constexpr double kStiff = 1.4;

}  // namespace cogrsim::bullet
