// Between Eigen and MuJoCo.
#pragma once

#include <algorithm>
#include <cmath>

#include "cogrsim/core/types.h"

namespace cogrsim::mujoco {

inline Vec3 vec_at(const double* v) { return {v[0], v[1], v[2]}; }
inline Quat quat_at(const double* q) { return {q[0], q[1], q[2], q[3]}; }

inline void put(double* to, const Vec3& v) { std::copy_n(v.data(), 3, to); }
inline void put(double* to, const Quat& q) {
  to[0] = q.w();
  put(to + 1, Vec3(q.vec()));
}

/// A coordinate that came out of poses: what differs from zero by rounding is zero.
inline double settled(double q) { return std::abs(q) < 1e-15 ? 0.0 : q; }

/// A unit vector that came out of a quaternion: what differs from an axis of its frame by rounding
/// is that axis.
inline Vec3 cleaned(Vec3 v) {
  for (double& x : v)
    if (std::abs(x - std::round(x)) < 1e-15) x = std::round(x);
  return v;
}

}  // namespace cogrsim::mujoco
