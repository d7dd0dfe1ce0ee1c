// What a convex mesh is to everyone who sees or touches it.
#pragma once

#include "cogrsim/model/shapes.h"

namespace cogrsim {

/// Convex hull of the mesh's vertices [m]: triangles counter-clockwise seen from outside, no texture
/// coordinates. Points without volume come back as the mesh they are.
COGRSIM_API TriangleMesh convex_hull(const TriangleMesh& mesh);

}  // namespace cogrsim
