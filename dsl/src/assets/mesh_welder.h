// Triangles by their corners as one mesh.
#pragma once

#include <string>
#include <unordered_map>

#include "assets/mesh_file.h"
#include "cogrsim/core/random.h"

namespace cogrsim::dsl {

/// Collects triangles and merges corners that are equal to the bit (both zeros are one).
class MeshWelder {
 public:
  /// False: two corners are one, and the triangle has no area and is dropped. Errors: too many.
  Result<bool> add(const Vec3 (&corners)[3]) {
    if (mesh_.triangles.size() >= kMaxMeshTriangles)
      return fail("more than " + std::to_string(kMaxMeshTriangles) + " triangles");
    Eigen::Vector3i triangle;
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = corners[i] + Vec3::Zero();  // -0 becomes +0
      const auto [at, is_new] = known_.try_emplace(p, static_cast<int>(mesh_.vertices.size()));
      if (is_new) {
        if (mesh_.vertices.size() >= kMaxMeshVertices)
          return fail("more than " + std::to_string(kMaxMeshVertices) + " vertices");
        mesh_.vertices.push_back(p);
      }
      triangle[i] = at->second;
    }
    const bool has_area =
        triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0];
    if (has_area) mesh_.triangles.push_back(triangle);
    return has_area;
  }

  Result<TriangleMesh> finish() {
    if (mesh_.triangles.empty()) return fail("the file has no triangles");
    return std::move(mesh_);
  }

 private:
  struct Hash {
    std::size_t operator()(const Vec3& p) const {
      return static_cast<std::size_t>(hash_bytes(p.data(), 3 * sizeof(double)));
    }
  };

  TriangleMesh mesh_;
  std::unordered_map<Vec3, int, Hash> known_;
};

}  // namespace cogrsim::dsl
