// Depths by trying directions, and shapes to try them on.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cogrsim/core/random.h"
#include "cogrsim/geometry/overlap.h"

namespace cogrsim::test {

/// Support function of a set along a direction of the world: max of n . p.
using Extent = std::function<double(const Vec3& n)>;

/// By each kind's closed form; depths and distances of the library come from its support points. Box, sphere, cylinder, capsule,
/// convex mesh.
Extent extent_of(const SceneModel& model, const Shape& shape, const Pose& X_WS);
Extent extent_of(const std::vector<Vec3>& points);

/// Overlap of two sets along n (unit): moving the second by this distance along n separates them.
double overlap_along(const Extent& a, const Extent& b, const Vec3& n);

/// The least overlap along `count` directions spread over the sphere, the best of them improved by
/// smaller and smaller steps; negative where some direction separates the two. Never below the true
/// value.
double least_overlap(const Extent& a, const Extent& b, int count = 1500);

/// "box" and so on, about 1 m in size, each with extents of its own.
const std::vector<std::string>& convex_kinds();
/// Makes one; a convex mesh is added to `model`, with points inside its hull, too.
Shape convex_shape(const std::string& kind, RandomStream& random, SceneModel& model);

Vec3 random_direction(RandomStream& random);
Quat random_turn(RandomStream& random);
Pose random_pose(RandomStream& random, double extent);

}  // namespace cogrsim::test
