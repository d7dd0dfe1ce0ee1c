// What collision detection finds.
#pragma once

#include "cogrsim/core/types.h"

namespace cogrsim::dynamics {

struct ContactPoint {
  int collider_a = -1, collider_b = -1;  ///< see Colliders; body of a < body of b
  Vec3 point = Vec3::Zero();             ///< world, halfway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();           ///< unit, from a to b
  double gap = 0.0;                      ///< negative: penetration [m]
};

}  // namespace cogrsim::dynamics
