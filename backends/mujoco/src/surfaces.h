// The scene's friction and restitution of a pair, by MuJoCo's means: it takes those of the geom with
// the higher priority, or the larger friction of two that have the same.
#pragma once

#include <string>
#include <vector>

#include "options.h"

#include "cogrsim/core/result.h"

namespace cogrsim::mujoco {

/// A geom as far as surfaces go.
struct SurfaceGeom {
  int body = -1;        ///< SceneModel::bodies
  int material = -1;    ///< SceneModel::materials
  bool mobile = false;  ///< of a body moved by forces
};

/// Priorities and surfaces of geoms, and what they cannot express.
struct Surfaces {
  std::vector<std::string> geoms;  ///< attributes, by geom
  std::string pairs;               ///< <pair> elements of geoms named "g0", "g1", …
};

/// Chooses priorities so that as few pairs of geoms as can be need an element of their own. Errors:
/// they would be too many.
Result<Surfaces> choose_surfaces(const SceneModel& model, const Options& options,
                                 const std::vector<SurfaceGeom>& geoms);

/// Damping ratio of a spring and dashpot from whose push a body leaves with `restitution` of the
/// speed with which it came (Schwager and Pöschel, Phys. Rev. E 75, 051304, 2007).
double damping_ratio(double restitution);

}  // namespace cogrsim::mujoco
