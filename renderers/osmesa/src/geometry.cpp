#include "geometry.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/triangles.h"

namespace cogrsim::osmesa {

namespace {

std::array<float, 3> to_floats(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::uint32_t add(Triangles& out, const Vec3& position, const Vec3& normal, double end = 0.0) {
  Vertex vertex;
  vertex.position = to_floats(position);
  vertex.normal = to_floats(normal);
  vertex.end = static_cast<float>(end);
  out.vertices.push_back(vertex);
  return static_cast<std::uint32_t>(out.vertices.size() - 1);
}

void add_triangle(Triangles& out, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  out.indices.insert(out.indices.end(), {a, b, c});
}

/// Two rows of vertices, the upper one above the lower one, running counter-clockwise seen from +z.
void add_strip(Triangles& out, std::uint32_t lower, std::uint32_t upper, int segments) {
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(segments); ++i) {
    add_triangle(out, lower + i, lower + i + 1, upper + i + 1);
    add_triangle(out, lower + i, upper + i + 1, upper + i);
  }
}

/// Radius of the regular polygon whose area is the unit circle's.
double equal_area_radius(int segments) {
  const double angle = 2.0 * kPi / segments;
  return std::sqrt(angle / std::sin(angle));
}

Triangles unit_box() {
  Triangles out;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero(), u = Vec3::Zero();
      normal[axis] = side;
      u[(axis + 1) % 3] = 1.0;
      const Vec3 v = normal.cross(u);
      const std::uint32_t first = add(out, 0.5 * (normal - u - v), normal);
      add(out, 0.5 * (normal + u - v), normal);
      add(out, 0.5 * (normal + u + v), normal);
      add(out, 0.5 * (normal - u + v), normal);
      add_triangle(out, first, first + 1, first + 2);
      add_triangle(out, first, first + 2, first + 3);
    }
  }
  return out;
}

/// Rows of latitude from the south pole up; with `split` the equator is there twice, once for each
/// half of a capsule, and the strip between is the cylinder's side.
Triangles unit_round(int segments, bool split) {
  Triangles out;
  const double radius = equal_area_radius(segments);
  const int half_rows = std::max(2, (segments + 3) / 4);
  std::uint32_t previous = 0;
  bool first = true;
  const auto row = [&](int latitude, double end) {
    const double angle = 0.5 * kPi * latitude / half_rows;
    std::uint32_t start = 0;
    for (int i = 0; i <= segments; ++i) {
      const double turn = 2.0 * kPi * (static_cast<double>(i) / segments - 0.5);
      const Vec3 n(std::cos(angle) * std::cos(turn), std::cos(angle) * std::sin(turn),
                   std::sin(angle));
      const std::uint32_t index = add(out, radius * n, n, end);
      if (i == 0) start = index;
    }
    if (!first) add_strip(out, previous, start, segments);
    previous = start;
    first = false;
  };
  for (int i = -half_rows; i <= 0; ++i) row(i, split ? -1.0 : 0.0);
  for (int i = split ? 0 : 1; i <= half_rows; ++i) row(i, split ? 1.0 : 0.0);
  // Half of the triangles at the poles have no area.
  const auto same = [&](std::uint32_t a, std::uint32_t b) {
    const Vertex &va = out.vertices[a], &vb = out.vertices[b];
    float distance = std::abs(va.end - vb.end);
    for (std::size_t i = 0; i < 3; ++i) {
      distance = std::max(distance, std::abs(va.position[i] - vb.position[i]));
    }
    return distance < 1e-6F;
  };
  std::vector<std::uint32_t> all;
  all.swap(out.indices);
  for (std::size_t i = 0; i < all.size(); i += 3) {
    const std::uint32_t a = all[i], b = all[i + 1], c = all[i + 2];
    if (!same(a, b) && !same(b, c) && !same(a, c)) add_triangle(out, a, b, c);
  }
  return out;
}

Triangles unit_cylinder(int segments) {
  Triangles out;
  const double radius = equal_area_radius(segments);
  const auto ring = [&](double z, const Vec3* normal) {
    std::uint32_t start = 0;
    for (int i = 0; i <= segments; ++i) {
      const double turn = 2.0 * kPi * (static_cast<double>(i) / segments - 0.5);
      const Vec3 side(std::cos(turn), std::sin(turn), 0.0);
      const std::uint32_t index =
          add(out, Vec3(radius * side.x(), radius * side.y(), z), normal ? *normal : side);
      if (i == 0) start = index;
    }
    return start;
  };
  const std::uint32_t lower = ring(-1.0, nullptr);
  const std::uint32_t upper = ring(1.0, nullptr);
  add_strip(out, lower, upper, segments);
  for (const double z : {-1.0, 1.0}) {
    const Vec3 normal(0.0, 0.0, z);
    const std::uint32_t rim = ring(z, &normal);
    for (std::uint32_t i = 1; i + 1 < static_cast<std::uint32_t>(segments); ++i) {
      if (z > 0) add_triangle(out, rim, rim + i, rim + i + 1);
      if (z < 0) add_triangle(out, rim, rim + i + 1, rim + i);
    }
  }
  return out;
}

/// Corner normals: the mean over the faces around a vertex that lie within 30 degrees of this one,
/// weighted by area; vertices at one position count as one.
Triangles smooth(const std::vector<Vec3>& vertices, const std::vector<Eigen::Vector3i>& faces) {
  const double kCrease = std::cos(30.0 * kPi / 180.0);
  std::map<std::array<double, 3>, std::vector<std::size_t>> around;
  std::vector<Vec3> normals;  // length: twice the area
  const auto corner = [&](std::size_t face, int k) -> const Vec3& {
    return vertices[faces[face][k]];
  };
  const auto key = [](const Vec3& v) { return std::array<double, 3>{v.x(), v.y(), v.z()}; };
  for (std::size_t f = 0; f < faces.size(); ++f) {
    normals.push_back((corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0)));
    for (int k = 0; k < 3; ++k) around[key(corner(f, k))].push_back(f);
  }
  Triangles out;
  std::map<std::array<float, 6>, std::uint32_t> known;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const double length = normals[f].norm();
    // One without area stays where it is, so that the order of the faces is the mesh's.
    const Vec3 own = length > 0.0 ? Vec3(normals[f] / length) : Vec3::UnitZ();
    std::array<std::uint32_t, 3> indices{};
    for (int k = 0; k < 3; ++k) {
      Vec3 sum = Vec3::Zero();
      for (const std::size_t other : around[key(corner(f, k))]) {
        if (normals[other].dot(own) >= kCrease * normals[other].norm()) sum += normals[other];
      }
      sum = sum.norm() > 0.0 ? sum.normalized() : own;
      const std::array<float, 3> p = to_floats(corner(f, k)), n = to_floats(sum);
      const auto [it, is_new] = known.try_emplace({p[0], p[1], p[2], n[0], n[1], n[2]},
                                                  static_cast<std::uint32_t>(out.vertices.size()));
      if (is_new) add(out, corner(f, k), sum);
      indices[k] = it->second;
    }
    add_triangle(out, indices[0], indices[1], indices[2]);
  }
  return out;
}

/// Number of the first vertex at the same place, to about a millionth of the extent.
std::vector<std::uint32_t> merged(const std::vector<Vertex>& vertices) {
  float extent = 0.0F;
  for (const Vertex& vertex : vertices) {
    for (const float x : vertex.position) extent = std::max(extent, std::abs(x));
  }
  const double cell = std::max(1e-6 * static_cast<double>(extent), 1e-30);
  std::map<std::array<std::int64_t, 4>, std::uint32_t> known;
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    const auto& [x, y, z] = vertices[i].position;
    out.push_back(known
                      .try_emplace({std::llround(x / cell), std::llround(y / cell),
                                    std::llround(z / cell), std::llround(vertices[i].end)},
                                   i)
                      .first->second);
  }
  return out;
}

}  // namespace

std::vector<std::uint32_t> edges_of(const Triangles& triangles) {
  const std::vector<std::uint32_t> place = merged(triangles.vertices);
  // Sides of triangles between two places; those of one edge stand beside each other.
  struct Side {
    std::uint64_t places;
    std::uint32_t a, b;
  };
  std::vector<Side> sides;
  sides.reserve(triangles.indices.size());
  for (std::size_t i = 0; i + 2 < triangles.indices.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t a = triangles.indices[i + k], b = triangles.indices[i + (k + 1) % 3];
      if (place[a] == place[b]) continue;
      if (place[a] > place[b]) std::swap(a, b);
      sides.push_back({std::uint64_t{place[a]} << 32U | place[b], a, b});
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& s, const Side& t) { return s.places < t.places; });
  const float alike = static_cast<float>(std::cos(15.0 * kPi / 180.0));
  const auto differ = [&](std::uint32_t a, std::uint32_t b) {
    const auto &m = triangles.vertices[a].normal, &n = triangles.vertices[b].normal;
    return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < alike;
  };
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    const Side& first = sides[i];
    bool jump = false;
    for (end = i + 1; end < sides.size() && sides[end].places == first.places; ++end)
      jump |= differ(first.a, sides[end].a) && differ(first.b, sides[end].b);
    if (jump || end == i + 1) out.insert(out.end(), {first.a, first.b});
  }
  return out;
}

int segments_for(double radius_pixels, double tolerance) {
  // A polygon of the circle's area strays from it by at most r (pi/n)^2 / 3, at its corners.
  const double wanted = kPi * std::sqrt(std::max(radius_pixels, 0.0) / (3.0 * tolerance));
  for (const int n : {8, 12, 16, 24, 32, 48, 64, 96, 128, 192}) {
    if (wanted <= n) return n;
  }
  return 256;
}

Triangles unit_shape(ShapeType type, int segments) {
  switch (type) {
    case ShapeType::sphere:
      return unit_round(segments, false);
    case ShapeType::capsule:
      return unit_round(segments, true);
    case ShapeType::cylinder:
      return unit_cylinder(segments);
    default:
      return unit_box();
  }
}

std::array<float, 4> unit_scale(const Shape& shape) {
  const float radius = static_cast<float>(shape.radius);
  const float half = static_cast<float>(0.5 * shape.length);
  switch (shape.type) {
    case ShapeType::box: {
      const std::array<float, 3> size = to_floats(shape.size);
      return {size[0], size[1], size[2], 0.0F};
    }
    case ShapeType::sphere:
      return {radius, radius, radius, 0.0F};
    case ShapeType::cylinder:
      return {radius, radius, half, 0.0F};
    case ShapeType::capsule:
      return {radius, radius, radius, half};
    default:
      return {1.0F, 1.0F, 1.0F, 0.0F};
  }
}

Triangles faces_of(const SceneModel& model, const Shape& shape) {
  if (shape.type == ShapeType::heightmap) {
    const TriangleMesh ground = geometry::triangles_of(*model.heightmaps[shape.heightmap]);
    return smooth(ground.vertices, ground.triangles);
  }
  const TriangleMesh& mesh = *model.meshes[shape.mesh];
  return smooth(mesh.vertices, mesh.triangles);
}

}  // namespace cogrsim::osmesa
