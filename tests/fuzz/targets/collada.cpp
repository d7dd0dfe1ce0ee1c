#include "assets/mesh_file.h"
#include "targets.h"

namespace cogrsim::fuzz {

void collada(std::string_view input) {
  const auto mesh = dsl::parse_collada(std::string(input));
  if (!mesh) {
    require(!mesh.error().message.empty(), "a refusal has a reason");
    return;
  }
  require(!mesh->triangles.empty(), "a mesh has triangles");
  for (const auto& triangle : mesh->triangles)
    for (const auto corner : triangle)
      require(corner >= 0 && static_cast<std::size_t>(corner) < mesh->vertices.size(),
              "corners are vertices");
  for (const Vec3& vertex : mesh->vertices) require(vertex.allFinite(), "vertices are finite");
}

}  // namespace cogrsim::fuzz
