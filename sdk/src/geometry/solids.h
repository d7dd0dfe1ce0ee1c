// Where a line is inside of a convex solid, in closed form and double precision.
#pragma once

#include <optional>

#include "cogrsim/core/types.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim::geometry {

/// The line origin + t direction is inside for in <= t <= out. What is touched counts as inside.
struct Crossing {
  double in = 0.0, out = 0.0;
  int in_face = 0, out_face = 0;  ///< box: axis 0 to 2; cylinder: 0 side, 1 cap
};

/// For box, sphere, cylinder and capsule; in the shape's frame. `direction` has unit length, and
/// `origin` is best not far away: take the line's point nearest to the shape's middle.
std::optional<Crossing> cross_solid(const Shape& shape, const Vec3& origin, const Vec3& direction);

/// Outward normal at a point of the surface, shape's frame; `face` as in Crossing.
Vec3 solid_normal(const Shape& shape, const Vec3& point, int face);

}  // namespace cogrsim::geometry
