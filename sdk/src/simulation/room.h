// Room for things that come while a world runs, and how near bodies are to each other.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"
#include "geometry/convex.h"

namespace cogrsim {

/// One colliding shape where it stands.
struct PlacedShape {
  const SceneModel* model = nullptr;
  const Shape* shape = nullptr;
  geometry::Core core;  ///< of what is convex
  Pose X_WS;
  int body = -1;
  double grown = 0.0;       ///< all round, horizontally [m]
  geometry::Bounds bounds;  ///< in the world, grown
};

/// Distance between the surfaces of two shapes [m]; 0 where they touch or overlap. Exact for
/// everything convex (geometry/gjk.h) and for planes; meshes and height maps
/// count as their triangles, a height map also with all that is below it. Two of those that have no
/// inside are infinitely far from each other. More than `enough`: some distance beyond it.
double shape_distance(const PlacedShape& a, const PlacedShape& b, double enough);

/// Distance between the nearest colliding surfaces of two bodies [m]; infinity: one has none.
double body_distance(const SceneModel& model, const WorldState& state, int a, int b);

/// What stands in a world at one time.
class Room {
 public:
  /// Both must outlive it.
  Room(const SceneModel& model, const WorldState& state);

  /// Name of a body that leaves no room for `fragment` at `pose`; empty: there is room. Surfaces are
  /// compared, not bounds. `clearance` [m] is kept all round, level with the ground: what carries the
  /// newcomer may touch it, up to kSunk deep.
  std::string in_the_way(const SceneModel& fragment, const Pose& pose, double clearance) const;

  /// People place things on others to about this depth [m].
  static constexpr double kSunk = 1e-3;

 private:
  const SceneModel& model_;
  std::vector<PlacedShape> shapes_;
};

}  // namespace cogrsim
