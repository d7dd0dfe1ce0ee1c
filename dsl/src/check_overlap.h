// Which bodies are inside each other at the start.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

struct Overlap {
  int body_a = -1, body_b = -1;    ///< body_a < body_b
  int shape_a = -1, shape_b = -1;  ///< within their bodies
  double depth = 0.0;              ///< [m]
};

/// Bodies that collide with each other and overlap by more than a hundredth of a millimetre; one
/// entry per pair of bodies, the deepest. Decided exactly for spheres, boxes and capsules among
/// each other (capsule and box excepted) and for every solid against planes; other pairs are left
/// to the engine. Linear in the number of shapes (a hashed grid for every size); ends after a
/// thousand pairs, and after a number of comparisons that no sensible scene reaches.
std::vector<Overlap> find_overlaps(const SceneModel& model);

}  // namespace cogrsim::dsl
