// Convex hull of points.
#pragma once

#include "cogrsim/model/shapes.h"

namespace cogrsim::geometry {

/// Triangles counter-clockwise seen from outside, by Qhull. What has no volume comes back as it is.
TriangleMesh convex_hull(const TriangleMesh& mesh);

}  // namespace cogrsim::geometry
