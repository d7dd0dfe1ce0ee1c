// Conversion of a placement to a pose.
#pragma once

#include "cogrsim/geometry/placement.h"

namespace cogrsim::dynamics {

using geometry::Placement;

/// The scalar part of its quaternion is not negative.
inline Pose pose_of(const Placement& X) {
  Quat q(X.R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return {X.p, q};
}

}  // namespace cogrsim::dynamics
