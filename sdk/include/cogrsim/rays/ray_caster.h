// Ray casting in the scene, for all ranging sensors. It uses the model and the poses of the bodies,
// so that the results are the same for all engines.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// A ray in the world frame.
struct Ray {
  Vec3 origin = Vec3::Zero();      ///< [m]
  Vec3 direction = Vec3::UnitX();  ///< of any length except zero; it is normalised
  double min_distance = 0.0;       ///< nearer hits are ignored [m], >= 0
  double max_distance = std::numeric_limits<double>::infinity();  ///< farther hits are ignored [m]
};

/// A hit of a ray; converts to false if the ray hits nothing.
struct RayHit {
  double distance = std::numeric_limits<double>::infinity();  ///< along the ray [m]; infinite: none
  int body = -1;                ///< index into SceneModel::bodies; -1: no hit
  int shape = -1;               ///< index into the shapes of the body
  int triangle = -1;            ///< of a mesh or heightmap; -1 on the hull of a mesh
  Vec3 point = Vec3::Zero();    ///< in the world frame [m]
  Vec3 normal = Vec3::UnitZ();  ///< unit vector in the world frame, opposite to the ray
  bool inside = false;          ///< the surface was hit from the inside
  explicit operator bool() const { return body >= 0; }
};

/// The shapes that a ray can hit: visible ones, colliding ones, or all. With `visible` a convex
/// mesh consists of the triangles of its file, as in images; with `colliding` of its hull.
enum class RayTargets { visible, colliding, any };

/// Finds the nearest intersections of rays with the scene. Distances are exact to 1e-9 m, with
/// closed forms in double precision for plane, box, sphere, cylinder and capsule, and triangles in
/// double precision for other shapes. Rays hit both sides of a surface. A plane is the surface of
/// its half-space. (If a ray grazes a surface, the rounding error of the ray divided by the angle
/// is added.)
///
/// Solids are closed: a ray along a face of a box or along the wall of a cylinder hits the solid at
/// its edge. A ray within a plane or a triangle does not hit it. Of several surfaces at the same
/// distance the first in the order of the model is hit.
class COGRSIM_API RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Sets the scene and the poses X_WB of its bodies (nbody). The update is cheap if only the poses
  /// have changed; for a new model the added and removed shapes are updated. Removed bodies and
  /// bodies without a finite pose are ignored.
  void update(const SceneModelPtr& model, const std::vector<Pose>& poses,
              RayTargets targets = RayTargets::visible);

  /// The nearest hit on a body that is not in the sorted list `ignored`. A ray hits nothing if its
  /// origin is not finite, its direction has no length, or min_distance exceeds max_distance.
  /// Several threads may call it at the same time between updates.
  RayHit cast(const Ray& ray, const std::vector<int>& ignored = {}) const;
  /// Casts several rays; `hits` gets one entry per ray.
  void cast(const std::vector<Ray>& rays, std::vector<RayHit>& hits,
            const std::vector<int>& ignored = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
