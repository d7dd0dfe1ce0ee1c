// What a convex shape turns towards another: a flat face, the line along a round side, or nothing.
#pragma once

#include <LinearMath/btTransform.h>

#include "cogrsim/model/shapes.h"

namespace cogrsim::bullet {

struct CollisionShape;

/// Part of a shape's surface, world frame.
struct SupportFeature {
  static constexpr int kMost = 24;

  /// face: a convex polygon of `count` corners, counter-clockwise seen from outside. line: the
  /// axis of a round side, of two points, the surface `radius` away from it [m].
  enum class Kind { none, face, line };

  Kind kind = Kind::none;
  int count = 0;
  btVector3 points[kMost];
  btVector3 normal;     ///< of a face, unit, outward
  double radius = 0.0;  ///< of a line
  bool tread = false;   ///< the line is a cylinder's, which may roll as a wheel
};

/// The feature that looks most along `direction` (unit, world). A cylinder's end is a polygon with
/// one corner where it reaches farthest, so that a coin rolls on its rim as on a circle. Spheres
/// have none.
void find_support_feature(const Shape& shape, const CollisionShape& collision,
                          const btTransform& X_WS, const btVector3& direction, SupportFeature& out);

/// Outward normal (unit, world) of the flat face that looks most along `direction` (unit, world);
/// false: the shape has no flat face.
bool nearest_face_normal(const Shape& shape, const CollisionShape& collision,
                         const btTransform& X_WS, const btVector3& direction, btVector3& normal);

}  // namespace cogrsim::bullet
