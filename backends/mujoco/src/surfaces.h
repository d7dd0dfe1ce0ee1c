// The scene's friction and restitution of a pair, by MuJoCo's means: what it makes of two geoms, or
// those of a <pair> of its own.
#pragma once

#include <string>
#include <vector>

#include "options.h"

namespace cogrsim::mujoco {

/// A geom as far as surfaces go.
struct SurfaceGeom {
  int body = -1;        ///< SceneModel::bodies
  int material = -1;    ///< SceneModel::materials
  bool mobile = false;  ///< of a body moved by forces
};

struct Surfaces {
  std::string classes;  ///< <default> elements: "s" and the index of the material
  std::string pairs;    ///< <pair> elements of geoms named "g0", "g1", …
};

/// Pairs of which MuJoCo would make something else have an element of their own.
Surfaces choose_surfaces(const SceneModel& model, const Options& options,
                         const std::vector<SurfaceGeom>& geoms);

}  // namespace cogrsim::mujoco
