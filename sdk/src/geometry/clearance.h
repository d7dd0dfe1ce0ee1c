// Whether a world has clearance for what is added while it runs.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/geometry/convex.h"

namespace cogrsim::geometry {

/// One colliding shape where it stands.
struct PlacedShape {
  const SceneModel* model = nullptr;
  const Shape* shape = nullptr;
  Core core;  ///< of what is convex
  Pose X_WS;
  int body = -1;
  double grown = 0.0;  ///< all round, horizontally [m]
  Bounds bounds;       ///< in the world, grown
};

/// What stands in a world at one time.
class Clearance {
 public:
  /// `model` must outlive it; its bodies have the poses X_WB (nbody).
  Clearance(const SceneModel& model, const std::vector<Pose>& X_WB);

  /// Name of a body that leaves no clearance for `fragment` at `pose`; empty: none. Surfaces are
  /// compared, not bounds. `clearance` [m] is kept all round, level with the ground: what carries the
  /// newcomer may touch it, up to kSunk deep.
  std::string in_the_way(const SceneModel& fragment, const Pose& pose, double clearance) const;

  /// People place things on others to about this depth [m].
  static constexpr double kSunk = 1e-3;

 private:
  const SceneModel& model_;
  std::vector<PlacedShape> shapes_;
};

}  // namespace cogrsim::geometry
