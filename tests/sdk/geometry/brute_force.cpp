#include "brute_force.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/hull_faces.h"

namespace cogrsim::test {

Extent extent_of(const std::vector<Vec3>& points) {
  return [points](const Vec3& n) {
    double most = -kInfinity;
    for (const Vec3& p : points) most = std::max(most, p.dot(n));
    return most;
  };
}

Extent extent_of(const SceneModel& model, const Shape& shape, const Pose& X_WS) {
  if (shape.type == ShapeType::convex_mesh) {
    std::vector<Vec3> points = model.meshes[shape.mesh]->vertices;
    for (Vec3& p : points) p = X_WS * p;
    return extent_of(points);
  }
  return [shape, X_WS](const Vec3& n) {
    const Vec3 d = X_WS.q.conjugate() * n;
    const double half = 0.5 * shape.length * std::abs(d.z());
    double around = shape.radius;  // of a sphere
    if (shape.type == ShapeType::box) around = 0.5 * shape.size.dot(d.cwiseAbs());
    if (shape.type == ShapeType::capsule) around += half;
    if (shape.type == ShapeType::cylinder) around = half + shape.radius * std::hypot(d.x(), d.y());
    return n.dot(X_WS.p) + around;
  };
}

double overlap_along(const Extent& a, const Extent& b, const Vec3& n) { return a(n) + b(-n); }

double least_overlap(const Extent& a, const Extent& b, int count) {
  struct Try {
    double overlap;
    Vec3 n;
  };
  std::vector<Try> tries;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const Vec3 n(r * std::cos(golden * i), r * std::sin(golden * i), z);
    tries.push_back({overlap_along(a, b, n), n});
  }
  constexpr std::ptrdiff_t kImproved = 6;
  std::partial_sort(tries.begin(), tries.begin() + kImproved, tries.end(),
                    [](const Try& p, const Try& q) { return p.overlap < q.overlap; });
  double least = tries.front().overlap;
  for (std::ptrdiff_t i = 0; i < kImproved; ++i) {
    Try best = tries[i];
    double turn = 0.0;  // a different one each time: a valley may lie between eight directions
    for (double step = 0.05; step > 1e-7; turn += 1.0) {
      const Vec3 x = best.n.unitOrthogonal(), y = best.n.cross(x);
      bool better = false;
      for (int k = 0; k < 8; ++k) {
        const double angle = 0.25 * kPi * k + turn;
        const Vec3 n = (best.n + step * (std::cos(angle) * x + std::sin(angle) * y)).normalized();
        const double overlap = overlap_along(a, b, n);
        if (overlap < best.overlap) best = {overlap, n}, better = true;
      }
      if (!better) step *= 0.7;
    }
    least = std::min(least, best.overlap);
  }
  return least;
}

const std::vector<std::string>& convex_kinds() {
  static const std::vector<std::string> kKinds = {"box", "sphere", "cylinder", "capsule", "hull"};
  return kKinds;
}

Shape convex_shape(const std::string& kind, RandomStream& random, SceneModel& model) {
  Shape shape;
  shape.size = {random.uniform(0.3, 1.5), random.uniform(0.3, 1.5), random.uniform(0.3, 1.5)};
  shape.radius = random.uniform(0.2, 0.7);
  shape.length = random.uniform(0.3, 1.5);
  if (kind == "box") shape.type = ShapeType::box;
  if (kind == "sphere") shape.type = ShapeType::sphere;
  if (kind == "cylinder") shape.type = ShapeType::cylinder;
  if (kind == "capsule") shape.type = ShapeType::capsule;
  if (kind == "hull") {
    TriangleMesh mesh;
    for (int i = 0; i < 30; ++i)
      mesh.vertices.emplace_back(random.uniform(-0.6, 0.6), random.uniform(-0.4, 0.4),
                                 random.uniform(-0.5, 0.5));
    const HullFaces hull = hull_faces(mesh, 100);
    mesh.vertices.insert(mesh.vertices.begin(), hull.vertices.begin(), hull.vertices.end());
    for (const std::vector<int>& face : hull.corners)
      for (std::size_t k = 2; k < face.size(); ++k)
        mesh.triangles.emplace_back(face[0], face[k - 1], face[k]);
    shape.type = ShapeType::convex_mesh;
    shape.mesh = static_cast<int>(model.meshes.size());
    model.meshes.push_back(std::make_shared<const TriangleMesh>(std::move(mesh)));
  }
  return shape;
}

Vec3 random_direction(RandomStream& random) {
  for (;;) {
    const Vec3 v(random.normal(), random.normal(), random.normal());
    if (v.norm() > 1e-3) return v.normalized();
  }
}

Quat random_turn(RandomStream& random) {
  const Eigen::Vector4d v(random.normal(), random.normal(), random.normal(), random.normal());
  const Eigen::Vector4d q = v.normalized();
  return {q[0], q[1], q[2], q[3]};
}

Pose random_pose(RandomStream& random, double extent) {
  const Vec3 p(random.uniform(-extent, extent), random.uniform(-extent, extent),
               random.uniform(-extent, extent));
  return {p, random_turn(random)};
}

}  // namespace cogrsim::test
