// Spatial types shared by every part of CogRSim. SI units throughout; right-handed frames, z up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cogrsim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Unit quaternion; in text and files the scalar comes first (w x y z). It is unaligned so that a
/// plugin compiled with other vector instructions has the same memory layout.
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Pose X_AB of a frame B in a frame A: p_A = p + q * p_B.
struct Pose {
  Vec3 p = Vec3::Zero();      ///< origin of B in A [m]
  Quat q = Quat(1, 0, 0, 0);  ///< orientation of B in A, unit length

  Pose() = default;
  Pose(const Vec3& position, const Quat& orientation) : p(position), q(orientation) {}

  /// Composition X_AC = X_AB * X_BC; the orientation is normalised.
  Pose operator*(const Pose& X_BC) const { return {p + q * X_BC.p, (q * X_BC.q).normalized()}; }
  /// Coordinates in A of the point with the coordinates p_B in B [m].
  Vec3 operator*(const Vec3& p_B) const { return p + q * p_B; }
  /// The inverse X_BA.
  Pose inverse() const {
    const Quat qi = q.conjugate();
    return {-(qi * p), qi};
  }
};

/// Velocity of a frame: linear velocity of its origin and angular velocity, both expressed in world
/// axes unless stated otherwise.
struct Twist {
  Vec3 linear = Vec3::Zero();   ///< [m/s]
  Vec3 angular = Vec3::Zero();  ///< [rad/s]

  /// Linear velocity [m/s] of the point fixed in the moving frame at the offset `r` from its origin
  /// [m], expressed in the same axes.
  Vec3 at(const Vec3& r) const { return linear + angular.cross(r); }
};

/// Force and torque. The documentation of each use states the reference point and the axes.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< [N m]
};

/// Colour in sRGB and opacity; each component is between 0 and 1.
struct Color {
  double r = 0.7, g = 0.7, b = 0.7, a = 1.0;
};

}  // namespace cogrsim
