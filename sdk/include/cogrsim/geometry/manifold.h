// Where two convex shapes touch: the least separation of boxes, and the points between two faces.
// All functions are pure; all vectors are along the axes of the world.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/geometry/placement.h"

namespace cogrsim::geometry {

struct ContactPoint {
  int collider_a = -1, collider_b = -1;  ///< whatever its user numbers shapes by
  Vec3 point = Vec3::Zero();             ///< world, halfway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();           ///< unit, from a to b
  double gap = 0.0;                      ///< negative: penetration [m]
};

/// A convex polygon (3 or more), segment (2) or point (1) of a surface, in order around.
struct Feature {
  static constexpr int kMost = 32;
  Vec3 points[kMost];
  int count = 0;
  void add(const Vec3& p) { points[count++] = p; }
};

/// Direction along which two convex shapes are nearest or overlap least, and by how much.
struct Separation {
  bool found = false;
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  double gap = 0.0;
  bool has_points = false;
  Vec3 on_a = Vec3::Zero(), on_b = Vec3::Zero();  ///< nearest points, world; with has_points
  double blur = 0.0;  ///< how far the shapes that were asked may be from the true ones [m]
};

/// A box with these half extents [m] about the origin of its frame.
struct PlacedBox {
  const Vec3& half;
  const Placement& X_WS;
};

/// Fifteen separating axes (Gottschalk, Lin, Manocha, "OBBTree: a hierarchical structure for rapid
/// interference detection", SIGGRAPH 1996). Not found: further apart than `margin` [m] along one of
/// them. Unlike there a pair of edges counts only where it is better than the best face by 2 % and
/// 1e-6 m: faces make steadier manifolds. Nearest points only between edges.
COGRSIM_API Separation separate_boxes(const PlacedBox& a, const PlacedBox& b, double margin);

/// Contact points between the faces, edges or corners that the two turn towards each other: their
/// projections along the normal are clipped against one another; `separation`'s nearest points
/// serve where that yields nothing nearer.
COGRSIM_API void face_contacts(const Feature& a, const Feature& b, const Separation& separation,
                               double margin, std::vector<ContactPoint>& out);

/// Keeps at most four of the points from `first` on: the deepest, and those that span most area.
COGRSIM_API void reduce_points(std::vector<ContactPoint>& points, std::size_t first);

}  // namespace cogrsim::geometry
