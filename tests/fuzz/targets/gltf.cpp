#include "assets/mesh_file.h"
#include "targets.h"

namespace cogrsim::fuzz {

void gltf(std::string_view input) {
  const auto loaded = dsl::parse_gltf(input, "", std::size_t{1} << 26);
  if (!loaded) {
    require(!loaded.error().message.empty(), "a refusal has a reason");
    return;
  }
  const TriangleMesh& mesh = loaded->mesh;
  require(loaded->files.empty(), "no file was read");
  require(!mesh.triangles.empty(), "a mesh has triangles");
  for (const auto& triangle : mesh.triangles)
    for (const auto corner : triangle)
      require(corner >= 0 && static_cast<std::size_t>(corner) < mesh.vertices.size(),
              "corners are vertices");
  for (const Vec3& vertex : mesh.vertices) require(vertex.allFinite(), "vertices are finite");
  require(mesh.uv.empty() || mesh.uv.size() == 3 * mesh.triangles.size(),
          "each corner has its place in the picture");
}

}  // namespace cogrsim::fuzz
