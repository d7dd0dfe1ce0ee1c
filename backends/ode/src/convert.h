// Between Eigen and ODE.
#pragma once

#include <ode/ode.h>

#include "cogrsim/core/types.h"

static_assert(sizeof(dReal) == sizeof(double), "ODE must be built for double precision");

namespace cogrsim::ode {

inline Vec3 to_vec(const dReal* v) { return {v[0], v[1], v[2]}; }

inline void copy_to(dReal* out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) out[i] = v[i];
  out[3] = 0.0;
}

/// The rotation by the vector `phi` [rad].
inline Quat rotation_by(const Vec3& phi) {
  const double angle = phi.norm();
  if (angle < 1e-9) return Quat(1.0, 0.5 * phi.x(), 0.5 * phi.y(), 0.5 * phi.z()).normalized();
  const Vec3 v = std::sin(0.5 * angle) / angle * phi;
  return Quat(std::cos(0.5 * angle), v.x(), v.y(), v.z());
}

/// The rotation vector of `q`, at most pi long [rad].
inline Vec3 rotation_vector(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double s = v.norm(), c = sign * q.w();
  return s < 1e-12 ? Vec3(2.0 * v) : Vec3(2.0 * std::atan2(s, c) / s * v);
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
inline void perpendiculars(const Vec3& n, Vec3& s, Vec3& t) {
  const Vec3 aside = std::abs(n.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
  s = n.cross(aside).normalized();
  t = n.cross(s);
}

}  // namespace cogrsim::ode
