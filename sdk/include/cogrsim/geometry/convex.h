// Convex shapes: the furthest points, extents and distances of all of them. All functions are pure.
#pragma once

#include <optional>

#include "cogrsim/geometry/bounds.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::geometry {

/// A convex set: all that is within `margin` of a core. What is curved all over is far easier to
/// measure by its core: a sphere's is its middle, a capsule's its middle line.
struct COGRSIM_API Core {
  enum class Kind { point, segment, box, cylinder, points } kind = Kind::point;
  Vec3 half = Vec3::Zero();      ///< box: half extents; segment, cylinder: half length in z [m]
  double radius = 0.0;           ///< of a cylinder [m]
  const Vec3* points = nullptr;  ///< not owned: corners of a hull, or of a triangle
  std::size_t count = 0;
  double margin = 0.0;  ///< [m]

  /// The point of the core furthest along `d`, both in the shape's frame.
  Vec3 support(const Vec3& d) const;
  /// How far all of it, margin included, reaches along `d` (unit) from the shape's origin [m].
  double extent(const Vec3& d) const;
  /// Half of the box along a frame's axes around all of it but points, margin included [m]; `R`
  /// turns from the shape's frame to that.
  Vec3 half_extents(const Mat3& R) const;
  /// The point of the core nearest to `p` in the shape's frame; nullopt: no closed form.
  std::optional<Vec3> nearest(const Vec3& p) const;
  /// Around all of it, margin included, in a frame where the shape's has the pose `X`.
  Bounds bounds(const Pose& X) const;
};

/// Of a box, sphere, cylinder or capsule, or of the hull of a mesh, which lasts as long as the
/// model.
COGRSIM_API Core core_of(const SceneModel& model, const Shape& shape);

/// Of a triangle that lasts as long; no margin.
COGRSIM_API Core core_of(const Vec3* corners);

/// Box along the axes of the shape's frame around all of it; of a plane the half-space z <= 0.
COGRSIM_API Bounds local_bounds(const SceneModel& model, const Shape& shape);

/// No point of the shape is farther from its origin [m]; of a plane infinite.
COGRSIM_API double bounding_radius(const SceneModel& model, const Shape& shape);

/// A ball around a shape, in its frame [m].
struct Ball {
  Vec3 middle = Vec3::Zero();
  double radius = 0.0;
};

/// The smallest of a box, sphere, cylinder or capsule; of a mesh or a heightmap about the middle of
/// its box. Of a plane infinite.
COGRSIM_API Ball bounding_ball(const SceneModel& model, const Shape& shape);

/// A core somewhere.
struct Placed {
  const Core& core;
  const Pose& X_WS;

  Vec3 support(const Vec3& d) const { return X_WS * core.support(X_WS.q.conjugate() * d); }
};

/// Distance of two cores, without their margins [m]; 0 where they touch or overlap. Closed forms to
/// a point and between segments, exact to 1e-12 of the coordinates; else gjk.h.
COGRSIM_API double core_distance(const Placed& a, const Placed& b);

/// From the core of `b` to that of `a` where they are nearest [m], with gjk.h's error.
COGRSIM_API Vec3 core_gap(const Placed& a, const Placed& b);

}  // namespace cogrsim::geometry
