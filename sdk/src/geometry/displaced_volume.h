// The part of a shape below a plane, for buoyancy.
#pragma once

#include <vector>

#include "cogrsim/model/shapes.h"

namespace cogrsim::geometry {

/// A volume [m^3] with its centroid in the world [m].
struct Displaced {
  double volume = 0.0;
  Vec3 centre = Vec3::Zero();
};

/// Exact for spheres (closed form) and for boxes and closed meshes (clipped triangles, divergence
/// theorem). A cylinder is a prism of 64 sides with its volume, exact while upright and within 0.1 %
/// of the volume otherwise. A capsule is a polyhedron, too, and lacks 0.25 % of the volume of its
/// caps. Planes and heightmaps have no volume.
class DisplacedShape {
 public:
  DisplacedShape(const Shape& shape, const std::vector<MeshPtr>& meshes);

  /// The part where up . x <= level, with the unit vector `up`.
  Displaced below(const Pose& X_WB, const Vec3& up, double level) const;

 private:
  Pose X_BS_;
  double radius_ = 0.0;  // of a sphere; else 0
  MeshPtr mesh_;         // of others; nullptr: without volume
};

}  // namespace cogrsim::geometry
