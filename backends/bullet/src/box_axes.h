// The direction in which two boxes are farthest apart or overlap least.
#pragma once

#include <LinearMath/btTransform.h>

namespace cogrsim::bullet {

/// Tries the fifteen axes that can separate two boxes (Gottschalk, Lin, Manocha, "OBBTree",
/// SIGGRAPH 1996): their faces' normals and the products of their edges. An edge must be clearly
/// better than the best face, and A's faces than B's, so that boxes that rest flush keep the same
/// one. `half_a`, `half_b`: half sizes [m]. False where an axis shows them more than `threshold`
/// [m] apart; else `normal` is set: unit, world, from B to A.
bool separating_axis(const btTransform& X_WA, const btVector3& half_a, const btTransform& X_WB,
                     const btVector3& half_b, double threshold, btVector3& normal);

}  // namespace cogrsim::bullet
