// How far apart the surfaces of things are.
#pragma once

#include <memory>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::geometry {

/// The solid of some bodies, or a point. Keeps what it needs of the model it was made from: shapes
/// do not change during a run.
///
/// Counted are the shapes that collide; of a body without one, those that are seen; of one without
/// shapes, its origin. Box, sphere, cylinder, capsule, convex hull and the half-space of a plane are
/// solid; a mesh and a heightmap are surfaces: what is inside a closed mesh has a distance to its
/// wall.
class SurfaceSet {
 public:
  static SurfaceSet of_bodies(const SceneModel& model, const std::vector<int>& bodies);
  static SurfaceSet of_point(int body, const Pose& X_BP);

  struct Piece;
  const std::vector<std::shared_ptr<const Piece>>& pieces() const { return pieces_; }

 private:
  std::vector<std::shared_ptr<const Piece>> pieces_;
};

/// Shortest distance between the two at `poses` X_WB (nbody) [m], 0 where they touch or overlap;
/// `gone(body)`: leave it out; NaN: nothing is left of one of them.
///
/// Closed forms to a point or sphere, between capsules, and from a plane to anything, exact to 1e-12
/// of the coordinates; else gjk.h, within 1e-9 m. Bounding balls, and a tree of boxes over the
/// triangles of a mesh, leave out what cannot be nearest.
double surface_distance(const SurfaceSet& a, const SurfaceSet& b, const std::vector<Pose>& poses,
                        const std::vector<bool>& gone);

}  // namespace cogrsim::geometry
