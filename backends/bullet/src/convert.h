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

/// Index of a vector of the model's.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace cogrsim::bullet
