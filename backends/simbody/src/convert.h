// Between Eigen's and Simbody's small vectors.
#pragma once

#include <Simbody.h>

#include "cogrsim/core/types.h"

namespace cogrsim::simbody {

inline SimTK::Vec3 to_simtk(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Vec3 from_simtk(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
inline SimTK::Rotation to_simtk(const Quat& q) {
  return SimTK::Rotation(SimTK::Quaternion(SimTK::Vec4(q.w(), q.x(), q.y(), q.z())));
}
inline Quat from_simtk(const SimTK::Rotation& R) {
  const SimTK::Quaternion q = R.convertRotationToQuaternion();
  return {q[0], q[1], q[2], q[3]};
}
inline SimTK::Transform to_simtk(const Pose& X) { return {to_simtk(X.q), to_simtk(X.p)}; }
inline Pose from_simtk(const SimTK::Transform& X) { return {from_simtk(X.p()), from_simtk(X.R())}; }

}  // namespace cogrsim::simbody
