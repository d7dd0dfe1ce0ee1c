// Contact points of one pair of shapes. All functions are pure: the same poses give the same
// points, whatever came before.
#pragma once

#include <vector>

#include "collision/colliders.h"

namespace cogrsim::dynamics {

/// Half-space z <= 0 of `plane` against a convex shape: closed forms. Normals from the plane.
void plane_contacts(const Collider& plane, const Collider& convex, double margin,
                    std::vector<ContactPoint>& out);

/// Bullet's GJK, and EPA where the shapes, shrunk by their margins, overlap. `axis`: gets where they are apart
/// along, if they are (world, unit).
Separation separate_convex(const btConvexShape& a, const btTransform& X_a, const btConvexShape& b,
                           const btTransform& X_b, double margin, Vec3* axis = nullptr);
btTransform to_bullet(const Placement& X);

/// How far two shapes were apart in an earlier step: what saves a search, and changes no result.
struct Apart {
  Vec3 axis = Vec3::Zero();  ///< world, unit, from the first to the second; zero: unknown
  double gap = 0.0;          ///< along it, at least [m]
};

/// Any pair of convex shapes.
void convex_contacts(const Collider& a, const Collider& b, double margin, Apart& apart,
                     std::vector<ContactPoint>& out);

/// A mesh or heightmap against a convex shape. Normals from the mesh; each triangle is solid below
/// and empty above its counter-clockwise face; edges shared by triangles that were touched on their
/// faces do not count.
void concave_contacts(const Collider& concave, const Collider& convex, double margin,
                      std::vector<ContactPoint>& out);

}  // namespace cogrsim::dynamics
