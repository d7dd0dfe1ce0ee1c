// Between the SDK's spatial types and Bullet's.
#pragma once

#include <LinearMath/btTransform.h>

#include "cogrsim/core/types.h"

namespace cogrsim::bullet {

inline btVector3 to_bt(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline btQuaternion to_bt(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }
inline btTransform to_bt(const Pose& X) { return btTransform(to_bt(X.q), to_bt(X.p)); }

inline Vec3 from_bt(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Quat from_bt(const btQuaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Pose from_bt(const btTransform& X) {
  return {from_bt(X.getOrigin()), from_bt(X.getRotation())};
}
inline Mat3 from_bt(const btMatrix3x3& m) {
  Mat3 out;
  for (int r = 0; r < 3; ++r) out.row(r) = from_bt(m[r]).transpose();
  return out;
}

}  // namespace cogrsim::bullet
