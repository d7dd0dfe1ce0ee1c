// Contact points of two convex shapes, found afresh from their poses.
#pragma once

#include "contact_patch.h"

#include "cogrsim/model/shapes.h"

namespace cogrsim::bullet {

struct CollisionShape;

/// Fills `patch` with the points of A and B (any of sphere, box, cylinder, capsule, convex mesh)
/// that come within `threshold` [m] of each other, at most as many as the patch holds. The
/// direction of contact comes from the fifteen separating axes of two boxes, or from the closest
/// points or least overlap of other shapes (Gilbert-Johnson-Keerthi, and the expanding polytope
/// where the shapes overlap by more than their rounding); the points from clipping the faces or
/// lines that look that way against each other. The closest points themselves are taken too where
/// they are nearer than all others, and where there are no others. The same poses give the same
/// points, whatever came before.
void convex_contacts(const Shape& a, const CollisionShape& collision_a, const btTransform& X_WA,
                     const Shape& b, const CollisionShape& collision_b, const btTransform& X_WB,
                     double threshold, ContactPatch& patch);

}  // namespace cogrsim::bullet
