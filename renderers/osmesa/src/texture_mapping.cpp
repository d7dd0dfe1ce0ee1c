#include "cogrsim/model/surface.h"
#include "geometry.h"

namespace cogrsim::osmesa {

Triangles textured(const SceneModel& model, const Shape& shape, const Triangles& plain) {
  const std::array<float, 4> scale = unit_scale(shape);
  const auto place = [&](const Vertex& v) {
    return Vec3(v.position[0] * scale[0], v.position[1] * scale[1],
                v.position[2] * scale[2] + v.end * scale[3]);
  };
  const bool by_face = shape.type == ShapeType::mesh || shape.type == ShapeType::convex_mesh;
  Triangles out;
  for (std::size_t i = 0; i + 2 < plain.indices.size(); i += 3) {
    const Vertex* corners[3];
    for (std::size_t k = 0; k < 3; ++k) corners[k] = &plain.vertices[plain.indices[i + k]];
    const Vec3 a = place(*corners[0]), b = place(*corners[1]), c = place(*corners[2]);
    const Vec3 middle = (a + b + c) / 3.0;
    const Vec3 across = (b - a).cross(c - a);
    const Vec3 face_normal = across.norm() > 0.0 ? across.normalized() : Vec3::UnitZ();
    for (const Vertex* corner : corners) {
      Vertex vertex = *corner;
      // A little inside the triangle, on its own side of any seam.
      const Vec3 p = place(vertex), inside = p + 1e-5 * (middle - p);
      const Vec3 own(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
      const Vec2 uv = texture_coordinates(model, shape, inside, by_face ? face_normal : own,
                                          static_cast<int>(i / 3));
      vertex.uv = {static_cast<float>(uv.x()), static_cast<float>(1.0 - uv.y())};
      out.indices.push_back(static_cast<std::uint32_t>(out.vertices.size()));
      out.vertices.push_back(vertex);
    }
  }
  return out;
}

}  // namespace cogrsim::osmesa
