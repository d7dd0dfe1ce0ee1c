#include "cogrsim/model/surface.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim {
namespace {

/// A point and the extents of a flat face along the directions of u and v.
struct FacePoint {
  Vec2 at = Vec2::Zero();
  Vec2 extent = Vec2::Ones();
};

/// Selects the face whose outward normal has the same largest component as `normal`.
FacePoint face_point(const Vec3& point, const Vec3& normal, const Vec3& extents) {
  const Vec3 size = normal.cwiseAbs();
  if (size.z() >= size.x() && size.z() >= size.y()) {
    const double v = normal.z() < 0.0 ? -point.y() : point.y();
    return {{point.x(), v}, {extents.x(), extents.y()}};
  }
  if (size.y() >= size.x()) {
    const double u = normal.y() < 0.0 ? point.x() : -point.x();
    return {{u, point.z()}, {extents.x(), extents.z()}};
  }
  const double u = normal.x() < 0.0 ? -point.y() : point.y();
  return {{u, point.z()}, {extents.y(), extents.z()}};
}

Vec2 on_face(const FacePoint& face, const std::optional<Vec2>& size) {
  if (size) return face.at.cwiseQuotient(*size);
  return face.at.cwiseQuotient(face.extent) + Vec2(0.5, 0.5);
}

/// u around the z axis.
double around(const Vec3& point, double radius, const std::optional<Vec2>& size) {
  const double phi = std::atan2(point.y(), point.x());
  return (size ? radius * phi / size->x() : phi / (2.0 * kPi)) + 0.5;
}

/// Height above the middle along the outline of a capsule.
double outline(double z, double radius, double half_length) {
  const double beyond = std::abs(z) - half_length;
  if (beyond <= 0.0) return z;
  return std::copysign(half_length + radius * std::asin(std::min(beyond / radius, 1.0)), z);
}

Vec2 on_triangle(const TriangleMesh& mesh, std::size_t triangle, const Vec3& point) {
  const Eigen::Vector3i& corners = mesh.triangles[triangle];
  const Vec3& a = mesh.vertices[corners[0]];
  const Vec3 ab = mesh.vertices[corners[1]] - a;
  const Vec3 ac = mesh.vertices[corners[2]] - a;
  const Vec3 normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  const Vec2* const uv = &mesh.uv[3 * triangle];
  if (area <= 0.0) return uv[0];
  const Vec3 ap = point - a;
  const double b = ap.cross(ac).dot(normal) / area;
  const double c = ab.cross(ap).dot(normal) / area;
  return uv[0] + b * (uv[1] - uv[0]) + c * (uv[2] - uv[0]);
}

}  // namespace

Vec2 texture_coordinates(const SceneModel& model, const Shape& shape, const Vec3& point,
                         const Vec3& normal, int triangle) {
  const std::optional<Vec2>& size = model.materials[shape.material].texture_size;
  const Vec2 step = size.value_or(Vec2(1.0, 1.0));
  const double half = 0.5 * shape.length;
  switch (shape.type) {
    case ShapeType::box:
      return on_face(face_point(point, normal, shape.size), size);
    case ShapeType::sphere: {
      const double latitude = std::asin(std::clamp(point.z() / shape.radius, -1.0, 1.0));
      const double v = size ? shape.radius * latitude / size->y() : latitude / kPi;
      return {around(point, shape.radius, size), v + 0.5};
    }
    case ShapeType::cylinder: {
      if (std::abs(normal.z()) * std::sqrt(2.0) >= 1.0) {
        const double width = 2.0 * shape.radius;
        return on_face(face_point(point, {0.0, 0.0, normal.z()}, {width, width, width}), size);
      }
      const double v = size ? (point.z() + half) / size->y() : point.z() / shape.length + 0.5;
      return {around(point, shape.radius, size), v};
    }
    case ShapeType::capsule: {
      const double s = outline(point.z(), shape.radius, half);
      const double v = size ? (s + half) / size->y() : s / shape.length + 0.5;
      return {around(point, shape.radius, size), v};
    }
    case ShapeType::plane:
      return point.head<2>().cwiseQuotient(step);
    case ShapeType::heightmap: {
      const HeightGrid& grid = *model.heightmaps[shape.heightmap];
      return on_face({point.head<2>(), {grid.size_x, grid.size_y}}, size);
    }
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      break;
  }
  const TriangleMesh& mesh = *model.meshes[shape.mesh];
  const auto index = static_cast<std::size_t>(triangle);
  if (triangle >= 0 && index < mesh.triangles.size() && 3 * index + 2 < mesh.uv.size())
    return on_triangle(mesh, index, point);
  return on_face(face_point(point, normal, Vec3::Ones()), step);
}

std::shared_ptr<const Image> TextureStore::texture(const Material& material) {
  if (material.texture.empty()) return nullptr;
  const auto [at, is_new] = images_.try_emplace(material.texture, nullptr);
  if (!is_new) return at->second;
  auto image = load_image(material.texture);
  if (image) {
    at->second = std::make_shared<const Image>(std::move(*image));
  } else if (problem_.empty()) {
    problem_ = "texture " + image.error().text();
  }
  return at->second;
}

Color sample(const Image& image, const Vec2& uv) {
  if (image.width <= 0 || image.height <= 0 || !uv.allFinite()) return {1.0, 1.0, 1.0, 1.0};
  // Position in pixels from the centre of the top left pixel; v points up, rows run down.
  const double width = image.width, height = image.height;
  const double x = (uv.x() - std::floor(uv.x())) * width - 0.5;
  const double y = (std::ceil(uv.y()) - uv.y()) * height - 0.5;
  const auto wrapped = [](double at, int count) {
    const int i = static_cast<int>(at);
    return i < 0 ? i + count : i >= count ? i - count : i;
  };
  const double left = std::floor(x), top = std::floor(y);
  const int columns[2] = {wrapped(left, image.width), wrapped(left + 1.0, image.width)};
  const int rows[2] = {wrapped(top, image.height), wrapped(top + 1.0, image.height)};
  double sum[4] = {0.0, 0.0, 0.0, image.channels == 4 ? 0.0 : 1.0};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double weight =
          (i == 0 ? 1.0 - (x - left) : x - left) * (j == 0 ? 1.0 - (y - top) : y - top) / 255.0;
      const std::uint8_t* const pixel = image.pixel(columns[i], rows[j]);
      for (int c = 0; c < image.channels; ++c) sum[c] += weight * pixel[c];
    }
  }
  if (image.channels == 1) return {sum[0], sum[0], sum[0], 1.0};
  return {sum[0], sum[1], sum[2], sum[3]};
}

}  // namespace cogrsim
