// The flat faces of the convex hull of a mesh, for backends.
#pragma once

#include <cstddef>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim {

/// The flat faces of a convex hull, each with all its corners.
struct HullFaces {
  std::vector<Vec3> vertices;  ///< corners of the hull [m]; exact copies of vertices of the mesh
  std::vector<Vec3> normals;   ///< one outward unit normal per face
  /// For each face the indices of its corners, counter-clockwise seen from outside.
  std::vector<std::vector<int>> corners;

  /// Mean of the corners: a point inside.
  Vec3 middle() const {
    Vec3 out = Vec3::Zero();
    for (const Vec3& v : vertices) out += v / static_cast<double>(vertices.size());
    return out;
  }
};

/// Computes the faces of the convex hull of a mesh; the face of the largest triangle comes first. A
/// vertex belongs to a face if its distance to the plane of the face is at most 1e-6 of the size of
/// the hull. A face with more than `most_corners` (at least 3) corners is reduced to that many
/// evenly spaced ones. The result has no faces if the points enclose no volume.
COGRSIM_API HullFaces hull_faces(const TriangleMesh& mesh, std::size_t most_corners);

}  // namespace cogrsim
