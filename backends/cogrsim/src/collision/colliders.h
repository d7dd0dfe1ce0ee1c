// The shapes of a scene, prepared for distance queries.
#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/hull_faces.h"
#include "cogrsim/geometry/manifold.h"
#include "cogrsim/model/scene_model.h"
#include "mechanism/placement.h"

namespace cogrsim::dynamics {

using geometry::ContactPoint;
using geometry::Feature;
using geometry::Separation;

/// One collision shape of one body.
struct Collider {
  int body = -1, shape = -1;  ///< model indices
  ShapeType type = ShapeType::box;
  int material = 0;
  bool moves = false;
  Vec3 surface_velocity = Vec3::Zero();  ///< in the shape's axes [m/s]
  Placement X_BS;
  geometry::Core core;  ///< of what is convex; a hull's points are those of `hull`
  double bounding_radius =
      0.0;  ///< no point is farther from the shape's origin [m]; plane: infinite
  std::shared_ptr<const HullFaces> hull;        ///< at most Feature::kMost corners a face
  std::shared_ptr<btConvexShape> convex;        ///< all convex types
  std::shared_ptr<btTriangleMesh> triangles;    ///< mesh
  std::shared_ptr<btBvhTriangleMeshShape> bvh;  ///< mesh
  HeightGridPtr grid;                           ///< heightmap

  // At the time of the query.
  Placement X_WS;
  double margin = 0.0;        ///< speculative margin: how far its surface may move in the step [m]
  Vec3 shift = Vec3::Zero();  ///< of its origin over the rest of the step [m]
  Vec3 turn = Vec3::Zero();   ///< over the rest of the step [rad]
  double moved = 0.0;         ///< since the last query, no point of it by more [m]

  /// Half of the axis-aligned box about its place that holds it, margin included [m]. Not of a plane.
  Vec3 half_extents() const {
    const bool closed_form = is_convex() && hull == nullptr;
    return (closed_form ? core.half_extents(X_WS.R) : Vec3(Vec3::Constant(bounding_radius))) +
           Vec3::Constant(margin);
  }
  /// How far the rest of the step moves its point at `point` (world) [m].
  Vec3 travel_of(const Vec3& point) const { return shift + turn.cross(point - X_WS.p); }
  bool is_convex() const { return type != ShapeType::plane && !is_concave(); }
  bool is_concave() const { return type == ShapeType::mesh || type == ShapeType::heightmap; }
};

/// Colliders of all shapes that collide, in model order; the index of one is stable for as long as
/// the model only grows, because shapes that do not collide keep an empty entry (body -1).
std::vector<Collider> make_colliders(const SceneModel& model);

/// What the shape turns towards `direction` (world, unit): a face, an edge or a corner, in the
/// world.
void support_feature(const Collider& collider, const Vec3& direction, Feature& out);

/// Calls use(normal) for the outward normals (world, unit) of the flat faces that may look towards the point
/// `other` (world), but for a hull's over which the point `near` (world) is lower than `least` [m].
template <class Use>
void for_face_normals(const Collider& c, const Vec3& other, const Vec3& near, double least,
                      const Use& use) {
  const Mat3& R = c.X_WS.R;
  if (c.type == ShapeType::convex_mesh) {
    const Vec3 local = R.transpose() * (near - c.X_WS.p);
    for (std::size_t f = 0; f < c.hull->normals.size(); ++f) {
      const Vec3 &n = c.hull->normals[f],
                 &on = c.hull->vertices[std::size_t(c.hull->corners[f][0])];
      if (n.dot(local - on) >= least) use(Vec3(R * n));
    }
  } else if (c.type == ShapeType::box || c.type == ShapeType::cylinder) {
    for (int k = c.type == ShapeType::box ? 0 : 2; k < 3; ++k)
      use(R.col(k).dot(other - c.X_WS.p) > 0.0 ? Vec3(R.col(k)) : Vec3(-R.col(k)));
  }
}

/// Outward normal (world, unit) of the flat face that looks most along `direction` (world, unit);
/// false: the shape has none.
bool face_normal(const Collider& collider, const Vec3& direction, Vec3& normal);

/// Farthest extent of a convex shape along a world direction beyond its origin [m].
double support_extent(const Collider& collider, const Vec3& direction);
/// A point of a convex shape that is as far along a world direction (unit) as any, world.
Vec3 support_point(const Collider& collider, const Vec3& direction);

}  // namespace cogrsim::dynamics
