// For backends: the flat faces of a convex mesh.
#pragma once

#include <cstddef>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim {

/// A convex hull as its flat faces, each with all its corners.
struct HullFaces {
  std::vector<Vec3> vertices;             ///< corners of the hull, those of the mesh to the bit [m]
  std::vector<Vec3> normals;              ///< one per face, unit, outward
  std::vector<std::vector<int>> corners;  ///< one per face, counter-clockwise seen from outside
};

/// Faces of the mesh's convex hull, that of the largest triangle first; what lies within 1e-6 of
/// the hull's size of a face's plane belongs to the face. Of a face with more than `most_corners`
/// (3 or more) corners, so many evenly spaced ones are kept. No faces: the points have no volume.
COGRSIM_API HullFaces hull_faces(const TriangleMesh& mesh, std::size_t most_corners);

}  // namespace cogrsim
