// Motion, force and inertia of rigid bodies as vectors of six, about one point.
#pragma once

#include "cogrsim/core/types.h"

namespace cogrsim::dynamics {

/// Angular part first, linear velocity at (force through, torque about) the component's origin,
/// world axes.
struct Spatial {
  Vec3 angular = Vec3::Zero();
  Vec3 linear = Vec3::Zero();

  void operator+=(const Spatial& o) {
    angular += o.angular;
    linear += o.linear;
  }
};
inline double dot(const Spatial& a, const Spatial& b) {
  return a.angular.dot(b.angular) + a.linear.dot(b.linear);
}

/// Mass, first and second moment of a body about a component's origin, world axes.
struct Inertia {
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  void operator+=(const Inertia& o) {
    mass += o.mass;
    moment += o.moment;
    second += o.second;
  }
  /// Momentum of the body moving with `v`; or the force that accelerates it so from rest.
  Spatial operator*(const Spatial& v) const {
    return {second * v.angular + moment.cross(v.linear), mass * v.linear + v.angular.cross(moment)};
  }
};

}  // namespace cogrsim::dynamics
