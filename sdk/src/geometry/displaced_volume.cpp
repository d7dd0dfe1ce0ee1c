#include "geometry/displaced_volume.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "core/index.h"

namespace cogrsim::geometry {
namespace {

/// A point of the outline of a solid of revolution about z.
struct Ring {
  double radius, z;
};

/// The solid as a polyhedron: polygons with the areas of the circles, joined by frusta.
MeshPtr revolved(const std::vector<Ring>& outline) {
  constexpr int kSides = 64;
  const double area = std::sqrt(2.0 * kPi / (kSides * std::sin(2.0 * kPi / kSides)));
  auto mesh = std::make_shared<TriangleMesh>();
  for (const Ring& ring : outline) {
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * kPi * k / kSides;
      mesh->vertices.emplace_back(area * ring.radius * std::cos(angle),
                                  area * ring.radius * std::sin(angle), ring.z);
    }
  }
  const int rings = static_cast<int>(outline.size());
  for (int k = 0; k < kSides; ++k) {
    const int next = (k + 1) % kSides, last = (rings - 1) * kSides;
    for (int r = 0; r + 1 < rings; ++r) {
      const int low = r * kSides, high = low + kSides;
      mesh->triangles.emplace_back(low + k, low + next, high + next);
      mesh->triangles.emplace_back(low + k, high + next, high + k);
    }
    if (k == 0 || k == kSides - 1) continue;
    mesh->triangles.emplace_back(0, next, k);
    mesh->triangles.emplace_back(last, last + k, last + next);
  }
  return mesh;
}

MeshPtr capsule(double radius, double length) {
  constexpr int kRings = 16;  // of a cap
  std::vector<Ring> outline;
  for (int i = 0; i <= kRings; ++i) {
    const double latitude = 0.5 * kPi * (static_cast<double>(i) / kRings - 1.0);
    outline.push_back({radius * std::cos(latitude), radius * std::sin(latitude) - 0.5 * length});
  }
  for (int i = kRings; i >= 0; --i) outline.push_back({outline[at(i)].radius, -outline[at(i)].z});
  return revolved(outline);
}

MeshPtr box(const Vec3& size) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (int i = 0; i < 8; ++i) {
    mesh->vertices.emplace_back((i & 1 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                                (i & 4 ? 0.5 : -0.5) * size.z());
  }
  const std::array<std::array<int, 4>, 6> faces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    mesh->triangles.emplace_back(f[0], f[1], f[2]);
    mesh->triangles.emplace_back(f[0], f[2], f[3]);
  }
  return mesh;
}

/// Sums tetrahedra with their apex in the plane, so that the cut face has none.
struct Sum {
  double volume = 0.0;
  Vec3 moment = Vec3::Zero();

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double v = a.dot(b.cross(c)) / 6.0;
    volume += v;
    moment += 0.25 * v * (a + b + c);
  }
};

}  // namespace

DisplacedShape::DisplacedShape(const Shape& shape, const std::vector<MeshPtr>& meshes)
    : X_BS_(shape.X_BS) {
  switch (shape.type) {
    case ShapeType::sphere:
      radius_ = shape.radius;
      break;
    case ShapeType::box:
      mesh_ = box(shape.size);
      break;
    case ShapeType::cylinder:
      mesh_ = revolved({{shape.radius, -0.5 * shape.length}, {shape.radius, 0.5 * shape.length}});
      break;
    case ShapeType::capsule:
      mesh_ = capsule(shape.radius, shape.length);
      break;
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      mesh_ = meshes[at(shape.mesh)];
      break;
    case ShapeType::plane:
    case ShapeType::heightmap:
      break;
  }
}

Displaced DisplacedShape::below(const Pose& X_WB, const Vec3& up, double level) const {
  const Pose X_WS = X_WB * X_BS_;
  const double depth = level - up.dot(X_WS.p);  // of the origin of the shape
  if (radius_ > 0.0) {
    const double h = std::clamp(radius_ + depth, 0.0, 2.0 * radius_);
    if (h == 0.0) return {};
    const double from_centre =
        0.75 * (2.0 * radius_ - h) * (2.0 * radius_ - h) / (3.0 * radius_ - h);
    return {kPi * h * h * (3.0 * radius_ - h) / 3.0, X_WS.p - from_centre * up};
  }
  if (!mesh_) return {};
  const Vec3 normal = X_WS.q.conjugate() * up;
  const Vec3 apex = depth * normal;
  Sum sum;
  for (const Eigen::Vector3i& triangle : mesh_->triangles) {
    std::array<Vec3, 3> corner;
    std::array<double, 3> deep{};
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] = mesh_->vertices[at(triangle[static_cast<int>(i)])] - apex;
      deep[i] = -normal.dot(corner[i]);
    }
    const auto under = std::count_if(deep.begin(), deep.end(), [](double d) { return d > 0.0; });
    if (under == 0) continue;
    if (under == 3) {
      sum.add(corner[0], corner[1], corner[2]);
      continue;
    }
    std::array<Vec3, 4> cut;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k = (i + 1) % 3;
      if (deep[i] > 0.0) cut[count++] = corner[i];
      if ((deep[i] > 0.0) != (deep[k] > 0.0))
        cut[count++] = corner[i] + deep[i] / (deep[i] - deep[k]) * (corner[k] - corner[i]);
    }
    for (std::size_t i = 2; i < count; ++i) sum.add(cut[0], cut[i - 1], cut[i]);
  }
  if (!(sum.volume > 0.0)) return {};
  return {sum.volume, X_WS * Vec3(apex + sum.moment / sum.volume)};
}

}  // namespace cogrsim::geometry
