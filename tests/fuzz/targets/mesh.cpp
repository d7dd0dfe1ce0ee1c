#include "assets/mesh_file.h"

#include <cmath>

#include "targets.h"

namespace cogrsim::fuzz {
namespace {

void check(const Result<TriangleMesh>& mesh) {
  if (!mesh) {
    require(!mesh.error().message.empty(), "a refusal has a reason");
    return;
  }
  require(!mesh->triangles.empty(), "a mesh has triangles");
  for (const auto& triangle : mesh->triangles) {
    for (const auto corner : triangle) {
      require(static_cast<std::size_t>(corner) < mesh->vertices.size(), "corners are vertices");
    }
  }
  for (const Vec3& vertex : mesh->vertices) require(vertex.allFinite(), "vertices are finite");
  dsl::open_edges(*mesh);
}

}  // namespace

void mesh(std::string_view input) {
  check(dsl::parse_obj(input));
  check(dsl::parse_stl(input));
  const auto grid = dsl::parse_heightmap(input, 2.0, 3.0, 0.5);
  if (!grid) return;
  require(grid->heights.size() ==
              static_cast<std::size_t>(grid->rows) * static_cast<std::size_t>(grid->columns),
          "a grid has the heights that its size asks for");
  for (const auto height : grid->heights) require(std::isfinite(height), "heights are finite");
}

}  // namespace cogrsim::fuzz
