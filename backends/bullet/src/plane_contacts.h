// Contact points in closed form: a convex shape above a plane, or above one triangle.
#pragma once

#include <vector>

#include "contact_patch.h"

#include "cogrsim/model/shapes.h"

namespace cogrsim::bullet {

struct CollisionShape;

/// A half-space: points x with normal . x <= offset are inside.
struct HalfSpace {
  btVector3 normal;
  double offset = 0.0;
};

/// Fills `patch` with the corners, rim points and poles of `shape` (A) that come within `threshold`
/// [m] of the plane (B), found exactly: the face of a box that looks at it most, both rims of a
/// lying cylinder (a wheel needs two points across its tread), four rim points of a standing one.
void plane_contacts(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                    const HalfSpace& plane, double threshold, ContactPatch& patch);

struct NearTriangle {
  btVector3 corners[3];
  btVector3 normal;
};

/// Convex against a static or kinematic triangle surface. Corners above a triangle touch its face
/// and feel its normal, so that seams between triangles are not felt; where none is, the closest
/// points (Gilbert-Johnson-Keerthi) are used. Triangles are felt from their outer side only.
/// `scratch` is working memory to be reused.
void surface_contacts(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                      const CollisionShape& surface, const btTransform& X_WC, double threshold,
                      ContactPatch& patch, std::vector<NearTriangle>& scratch);

}  // namespace cogrsim::bullet
