// Between Eigen and ODE.
#pragma once

#include <ode/ode.h>

#include "cogrsim/core/types.h"

static_assert(sizeof(dReal) == sizeof(double), "ODE must be built for double precision");

namespace cogrsim::ode {

inline Vec3 to_vec(const dReal* v) { return {v[0], v[1], v[2]}; }
inline Quat to_quat(const dReal* q) { return {q[0], q[1], q[2], q[3]}; }

/// The rotation vector of `q`, at most pi long [rad].
inline Vec3 rotation_vector(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double s = v.norm(), c = sign * q.w();
  return s < 1e-12 ? Vec3(2.0 * v) : Vec3(2.0 * std::atan2(s, c) / s * v);
}

}  // namespace cogrsim::ode
