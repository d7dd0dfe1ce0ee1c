// Rays against many bodies: our caster and Bullet's, on the same scene.
#pragma once

#include <memory>
#include <vector>

#include "cogrsim/rays/ray_caster.h"

namespace cogrsim::bench {

/// A world of bare Bullet with the bodies of a model, for rayTest only.
class BulletRays {
 public:
  virtual ~BulletRays() = default;
  /// Distances of the nearest hits between 0 and `length` [m]; infinite: none.
  virtual void cast(const std::vector<Ray>& rays, double length,
                    std::vector<double>& distances) = 0;
};

/// For boxes, spheres, cylinders and capsules.
std::unique_ptr<BulletRays> make_bullet_rays(const SceneModel& model);

}  // namespace cogrsim::bench
