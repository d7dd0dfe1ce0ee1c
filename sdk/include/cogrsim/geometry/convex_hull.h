// Convex hulls of points, in space and in a plane. All functions are pure.
#pragma once

#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim::geometry {

/// Triangles counter-clockwise seen from outside, by Qhull. What has no volume comes back as it is.
COGRSIM_API TriangleMesh convex_hull(const TriangleMesh& mesh);

/// Corners of the hull, counter-clockwise from the one with the least x (of these the least y), by
/// the monotone chain of Andrew, "Another efficient algorithm for convex hulls in two dimensions",
/// Information Processing Letters 9 (1979). Points inside of an edge are left out; of points in one
/// line the two ends come back, of equal ones one.
COGRSIM_API std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace cogrsim::geometry
