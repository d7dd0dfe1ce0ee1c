// Convex shapes: cores, and the radius around them.
#pragma once

#include <optional>

#include "cogrsim/model/scene_model.h"
#include "geometry/bounds.h"

namespace cogrsim::geometry {

/// A convex set: all that is within `margin` of a core. What is curved all over is far easier to
/// measure by its core: a sphere's is its middle, a capsule's its middle line.
struct Core {
  enum class Kind { point, segment, box, cylinder, points } kind = Kind::point;
  Vec3 half = Vec3::Zero();      ///< box: half extents; segment, cylinder: half length in z [m]
  double radius = 0.0;           ///< of a cylinder [m]
  const Vec3* points = nullptr;  ///< not owned: corners of a hull, or of a triangle
  std::size_t count = 0;
  double margin = 0.0;  ///< [m]

  /// The point of the core furthest along `d`, both in the shape's frame.
  Vec3 support(const Vec3& d) const;
  /// The point of the core nearest to `p` in the shape's frame; nullopt: no closed form.
  std::optional<Vec3> nearest(const Vec3& p) const;
  /// Around all of it, margin included, in a frame where the shape's has the pose `X`.
  Bounds bounds(const Pose& X) const;
};

/// Of a box, sphere, cylinder, capsule or convex hull; of a hull it lasts as long as the model.
Core core_of(const SceneModel& model, const Shape& shape);

/// Of a triangle that lasts as long; no margin.
Core core_of(const Vec3* corners);

/// A core somewhere.
struct Placed {
  const Core& core;
  const Pose& X_WS;

  Vec3 support(const Vec3& d) const { return X_WS * core.support(X_WS.q.conjugate() * d); }
};

/// Distance of two cores, without their margins [m]; 0 where they touch or overlap. Closed forms to
/// a point and between segments, exact to 1e-12 of the coordinates; else gjk.h.
double core_distance(const Placed& a, const Placed& b);

/// From the core of `b` to that of `a` where they are nearest [m], with gjk.h's error.
Vec3 core_gap(const Placed& a, const Placed& b);

}  // namespace cogrsim::geometry
