// The scene's friction and restitution of a pair, by MuJoCo's means: those of the geom with the
// higher priority, the larger friction of two that have the same, or those of a <pair> of its own.
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

/// The class of defaults whose surface `geom` has.
std::string surface_class(const SurfaceGeom& geom);

struct Surfaces {
  std::string classes;  ///< <default> elements
  std::string pairs;    ///< <pair> elements of geoms named "g0", "g1", …
};

/// Chooses priorities so that few pairs of geoms need an element of their own.
Surfaces choose_surfaces(const SceneModel& model, const Options& options,
                         const std::vector<SurfaceGeom>& geoms);

}  // namespace cogrsim::mujoco
