// Rays against the scene: what every ranging sensor sees. Computed from model and poses, the same
// for all engines.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

struct Ray {
  Vec3 origin = Vec3::Zero();      ///< world [m]
  Vec3 direction = Vec3::UnitX();  ///< world; brought to unit length
  double min_distance = 0.0;       ///< hits nearer than this are not seen [m], >= 0
  double max_distance = std::numeric_limits<double>::infinity();  ///< nor further ones [m]
};

struct RayHit {
  double distance = std::numeric_limits<double>::infinity();  ///< along the ray [m]; infinite: none
  int body = -1;                ///< SceneModel::bodies; -1: nothing hit
  int shape = -1;               ///< within its body
  int triangle = -1;            ///< of a mesh or heightmap; -1 on its hull
  Vec3 point = Vec3::Zero();    ///< world [m]
  Vec3 normal = Vec3::UnitZ();  ///< world, unit, against the ray
  bool inside = false;          ///< the surface was met from within
  explicit operator bool() const { return body >= 0; }
};

/// Which shapes a ray meets: those that can be seen, those that can be touched, or both kinds. A
/// convex mesh is seen as the triangles of its file, as in pictures; `colliding` meets its hull.
enum class RayTargets { visible, colliding, any };

/// Nearest intersections. Distances are exact to 1e-9 m: closed forms in double for plane, box,
/// sphere, cylinder and capsule, triangles in double for the rest; both sides of a surface are hit.
/// A plane is the surface of its half-space. (Where a ray grazes a surface, the rounding of its own
/// numbers moves the point by that divided by the angle.)
///
/// Solids are closed: a ray that runs along a face of a box, or along a cylinder's wall, hits it
/// where it meets the rim. A ray within a plane or within a triangle does not hit that. Of
/// surfaces at one distance the first in the model's order is hit.
class COGRSIM_API RayCaster {
 public:
  RayCaster();
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// Takes the scene's shapes at the poses X_WB (nbody). Cheap when only poses changed; when
  /// `model` is another one than last time, what was added or removed is brought up to date.
  /// Removed bodies, and those without a pose or with one that is not finite, are not there.
  void update(const SceneModelPtr& model, const std::vector<Pose>& poses,
              RayTargets targets = RayTargets::visible);

  /// The nearest hit, bodies in `ignored` (sorted) left out. A ray whose origin is not finite,
  /// whose direction has no length, or with min_distance above max_distance, hits nothing. Safe
  /// from several threads at once between updates.
  RayHit cast(const Ray& ray, const std::vector<int>& ignored = {}) const;
  /// Many at once; `hits` gets rays.size() entries.
  void cast(const std::vector<Ray>& rays, std::vector<RayHit>& hits,
            const std::vector<int>& ignored = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
