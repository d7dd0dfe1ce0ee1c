// Spatial types shared by every part of CogRSim. SI units throughout; right-handed frames, z up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cogrsim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Unit quaternion, scalar first in text and files (w x y z).
/// Unaligned on purpose: a plugin compiled with other vector flags must see the same layout.
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Pose X_AB of a frame B in a frame A: p_A = p + q * p_B.
struct Pose {
  Vec3 p = Vec3::Zero();      ///< origin of B in A [m]
  Quat q = Quat(1, 0, 0, 0);  ///< orientation of B in A, unit length

  Pose() = default;
  Pose(const Vec3& position, const Quat& orientation) : p(position), q(orientation) {}

  /// X_AC = X_AB * X_BC.
  Pose operator*(const Pose& X_BC) const { return {p + q * X_BC.p, (q * X_BC.q).normalized()}; }
  /// Position of a point given in B, expressed in A [m].
  Vec3 operator*(const Vec3& p_B) const { return p + q * p_B; }
  /// X_BA.
  Pose inverse() const {
    const Quat qi = q.conjugate();
    return {-(qi * p), qi};
  }
};

/// Velocity of a frame: of its origin, and angular; both expressed in the world unless said.
struct Twist {
  Vec3 linear = Vec3::Zero();   ///< [m/s]
  Vec3 angular = Vec3::Zero();  ///< [rad/s]

  /// Linear velocity of a point fixed in the moving frame, `r` away from its origin [m], same axes.
  Vec3 at(const Vec3& r) const { return linear + angular.cross(r); }
};

/// Force and torque about a stated point, expressed in stated axes.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< [N m]
};

/// Red, green and blue as screens and picture files have them (sRGB), and opacity; each 0 to 1.
struct Color {
  double r = 0.7, g = 0.7, b = 0.7, a = 1.0;
};

}  // namespace cogrsim
