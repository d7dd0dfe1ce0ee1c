// A pose as matrix: cheaper to turn vectors with.
#pragma once

#include "cogrsim/core/types.h"

namespace cogrsim::geometry {

/// Axes of a frame and the position of its origin.
struct Placement {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();

  Placement() = default;
  Placement(const Mat3& rotation, const Vec3& origin) : R(rotation), p(origin) {}
  explicit Placement(const Pose& X) : R(X.q.toRotationMatrix()), p(X.p) {}

  Placement operator*(const Placement& b) const { return {R * b.R, p + R * b.p}; }
  Vec3 operator*(const Vec3& v) const { return p + R * v; }
  /// From the world into this frame.
  Vec3 to_local(const Vec3& world) const { return R.transpose() * (world - p); }
};

}  // namespace cogrsim::geometry
