// Contact points of one pair of shapes. All functions are pure: the same poses give the same
// points, whatever came before.
#pragma once

#include <vector>

#include "collision/colliders.h"
#include "collision/contact_point.h"

namespace cogrsim::dynamics {

/// Direction along which two convex shapes are nearest or overlap least, and by how much.
struct Separation {
  bool found = false;
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  double gap = 0.0;
  bool has_points = false;
  Vec3 on_a = Vec3::Zero(), on_b = Vec3::Zero();  ///< nearest points, world; with has_points
  double blur = 0.0;  ///< how far the shapes that were asked may be from the true ones [m]
};

/// Half-space z <= 0 of `plane` against a convex shape: closed forms. Normals from the plane.
void plane_contacts(const Collider& plane, const Collider& convex, double margin,
                    std::vector<ContactPoint>& out);

/// Fifteen separating axes (Gottschalk, Lin, Manocha 1996).
Separation separate_boxes(const Collider& a, const Collider& b, double margin);

/// Bullet's GJK, and EPA where the shapes, shrunk by their margins, overlap.
Separation separate_convex(const btConvexShape& a, const btTransform& X_a, const btConvexShape& b,
                           const btTransform& X_b, double margin);
btTransform to_bullet(const Placement& X);

/// Contact points between the faces, edges or corners that the two turn towards each other: their
/// projections along the normal are clipped against one another; `separation`'s nearest points
/// serve where that yields nothing nearer.
void face_contacts(const Feature& a, const Feature& b, const Separation& separation, double margin,
                   std::vector<ContactPoint>& out);

/// Keeps at most four of the points from `first` on: the deepest, and those that span most area.
void reduce_points(std::vector<ContactPoint>& points, std::size_t first);

/// Any pair of convex shapes.
void convex_contacts(const Collider& a, const Collider& b, double margin,
                     std::vector<ContactPoint>& out);

/// A mesh or heightmap against a convex shape. Normals from the mesh; each triangle is solid below
/// and empty above its counter-clockwise face; edges shared by triangles that were touched on their
/// faces do not count.
void concave_contacts(const Collider& concave, const Collider& convex, double margin,
                      std::vector<ContactPoint>& out);

}  // namespace cogrsim::dynamics
