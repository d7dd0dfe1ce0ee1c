// Which shapes are inside each other, and how deep.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::geometry {

/// The shortest translation that parts two shapes. Moving the second by `depth` along `normal`, or
/// the first against it, leaves them touching.
struct Penetration {
  double depth = 0.0;           ///< [m]; 0: they are apart or touch
  Vec3 normal = Vec3::UnitZ();  ///< world axes, unit, from the first to the second
};

/// Of two shapes whose frames have the poses X_WA and X_WB in the world. Box, sphere, cylinder,
/// capsule and convex mesh among each other: the depth is never too small, and too large by at most
/// 1e-4 of itself + 1e-10 of the shapes' size (where a cylinder is not concerned: by the latter
/// only). Of these with what is ground:
///
/// - a plane: how far the shape reaches below it;
/// - a heightmap: how far the shape must be lifted along the map's z until all of it is above the
///   ground, which is full below;
/// - a mesh, which is a surface without an inside: the deepest of the shape's depths in each of the
///   triangles; what a closed mesh holds, or lies beyond, touches nothing.
///
/// Two shapes that are ground: 0.
COGRSIM_API Penetration penetration(const SceneModel& model, const Shape& a, const Pose& X_WA,
                                    const Shape& b, const Pose& X_WB);

struct Overlap {
  int body_a = -1, body_b = -1;    ///< body_a < body_b
  int shape_a = -1, shape_b = -1;  ///< within their bodies
  double depth = 0.0;              ///< [m]
  Vec3 normal = Vec3::UnitZ();     ///< world axes, unit, from a to b
  Vec3 point = Vec3::Zero();       ///< of the world: the middle of what their bounds share
};

struct Overlaps {
  std::vector<Overlap> pairs;  ///< one for each pair of bodies, the deepest; by body_a, body_b
  bool complete = true;        ///< false: ended before all pairs were compared
};

/// Less is how people place things on each other [m]: sizes are written to hundredths of a
/// millimetre, and mesh files hold numbers in single precision, which is 4e-6 m at 100 m. Rounding
/// of the computation is below 1e-9 m.
inline constexpr double kTouchingDepth = 1e-5;

/// The bodies of `model` that collide with each other (CollisionFilter) and overlap by more than
/// kTouchingDepth at the start. A tree of bounding boxes finds the pairs to compare: n log n for n
/// shapes that are spread out. Ends after a thousand pairs of bodies, or after about a second's worth
/// of comparisons, which no scene but one made for it reaches.
COGRSIM_API Overlaps find_overlaps(const SceneModel& model);

}  // namespace cogrsim::geometry
