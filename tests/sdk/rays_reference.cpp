#include "rays_reference.h"

#include <cmath>
#include <functional>

#include "cogrsim/model/builder.h"

namespace cogrsim::reference {
namespace {

using Real = long double;
using Vec = Eigen::Matrix<Real, 3, 1>;
using Turn = Eigen::Quaternion<Real, Eigen::DontAlign>;

constexpr double kPi = 3.14159265358979323846;

Vec widen(const Vec3& v) { return v.cast<Real>(); }
Turn widen(const Quat& q) { return Turn(q.w(), q.x(), q.y(), q.z()).normalized(); }

/// A ray in a shape's frame, and the nearest hit found on it so far.
struct Line {
  Vec o, d;
  Real from, to;
  Real best = std::numeric_limits<Real>::infinity();

  void offer(Real t) {
    if (t >= from && t <= to && t < best) best = t;
  }
  Vec at(Real t) const { return o + t * d; }
};

/// Offers the roots of a t^2 + 2 b t + c = 0 where `counts`.
void offer_roots(Line& line, Real a, Real b, Real c,
                 const std::function<bool(const Vec&)>& counts) {
  const Real discriminant = b * b - a * c;
  if (a == 0 || discriminant < 0) return;
  // Citardauq for the root that would cancel.
  const Real q = -(b + std::copysign(std::sqrt(discriminant), b));
  for (const Real t : {q / a, c / q})
    if (counts(line.at(t))) line.offer(t);
}

void offer_flat(Line& line, int axis, Real level, const std::function<bool(const Vec&)>& counts) {
  if (line.d[axis] == 0) return;
  const Real t = (level - line.o[axis]) / line.d[axis];
  if (counts(line.at(t))) line.offer(t);
}

void offer_sphere(Line& line, const Vec& middle, Real radius,
                  const std::function<bool(const Vec&)>& counts) {
  const Vec o = line.o - middle;
  offer_roots(line, line.d.squaredNorm(), o.dot(line.d), o.squaredNorm() - radius * radius, counts);
}

void offer_side(Line& line, Real radius, Real half) {
  const Real a = line.d.x() * line.d.x() + line.d.y() * line.d.y();
  const Real b = line.o.x() * line.d.x() + line.o.y() * line.d.y();
  const Real c = line.o.x() * line.o.x() + line.o.y() * line.o.y() - radius * radius;
  offer_roots(line, a, b, c, [&](const Vec& p) { return std::abs(p.z()) <= half; });
}

void offer_triangle(Line& line, const Vec& a, const Vec& b, const Vec& c) {
  // a + u (b - a) + v (c - a) = o + t d, by Cramer's rule.
  const Vec ab = b - a, ac = c - a, ao = line.o - a;
  const Real determinant = -line.d.dot(ab.cross(ac));
  if (determinant == 0) return;
  const Real u = -line.d.dot(ao.cross(ac)) / determinant;
  const Real v = -line.d.dot(ab.cross(ao)) / determinant;
  const Real t = ao.dot(ab.cross(ac)) / determinant;
  const Real edge = -1e-17L;  // neighbours must not leave a gap
  if (u >= edge && v >= edge && u + v <= 1 - edge) line.offer(t);
}

void offer_grid(Line& line, const HeightGrid& grid) {
  const auto corner = [&](int column, int row) {
    return Vec(Real(grid.size_x) * (Real(column) / (grid.columns - 1) - 0.5L),
               Real(grid.size_y) * (Real(row) / (grid.rows - 1) - 0.5L),
               grid.heights[row * grid.columns + column]);
  };
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const Vec low = corner(column, row), high = corner(column + 1, row + 1);
      offer_triangle(line, low, corner(column + 1, row), high);
      offer_triangle(line, low, high, corner(column, row + 1));
    }
  }
}

void offer_shape(Line& line, const SceneModel& model, const Shape& shape) {
  const Real radius = shape.radius, half = Real(shape.length) / 2;
  const Vec size = widen(shape.size) / 2;
  switch (shape.type) {
    case ShapeType::box:
      for (int axis = 0; axis < 3; ++axis) {
        for (const Real level : {-size[axis], size[axis]}) {
          offer_flat(line, axis, level, [&](const Vec& p) {
            const int i = (axis + 1) % 3, j = (axis + 2) % 3;
            return std::abs(p[i]) <= size[i] && std::abs(p[j]) <= size[j];
          });
        }
      }
      break;
    case ShapeType::sphere:
      offer_sphere(line, Vec::Zero(), radius, [](const Vec&) { return true; });
      break;
    case ShapeType::cylinder:
      offer_side(line, radius, half);
      for (const Real level : {-half, half}) {
        offer_flat(line, 2, level,
                   [&](const Vec& p) { return p.x() * p.x() + p.y() * p.y() <= radius * radius; });
      }
      break;
    case ShapeType::capsule:
      offer_side(line, radius, half);
      offer_sphere(line, Vec(0, 0, half), radius, [&](const Vec& p) { return p.z() >= half; });
      offer_sphere(line, Vec(0, 0, -half), radius, [&](const Vec& p) { return p.z() <= -half; });
      break;
    case ShapeType::plane:
      offer_flat(line, 2, 0, [](const Vec&) { return true; });
      break;
    case ShapeType::convex_mesh:
    case ShapeType::mesh: {
      const TriangleMesh& mesh = *model.meshes[shape.mesh];
      for (const Eigen::Vector3i& t : mesh.triangles) {
        offer_triangle(line, widen(mesh.vertices[t[0]]), widen(mesh.vertices[t[1]]),
                       widen(mesh.vertices[t[2]]));
      }
      break;
    }
    case ShapeType::heightmap:
      offer_grid(line, *model.heightmaps[shape.heightmap]);
      break;
  }
}

/// Bounding radius of the shape about its frame's origin.
Real bounding_radius(const SceneModel& model, const Shape& shape) {
  switch (shape.type) {
    case ShapeType::plane:
    case ShapeType::heightmap:
      return std::numeric_limits<Real>::infinity();
    case ShapeType::convex_mesh:
    case ShapeType::mesh: {
      Real most = 0;
      for (const Vec3& v : model.meshes[shape.mesh]->vertices)
        most = std::max(most, widen(v).norm());
      return most;
    }
    default:
      return shape.size.norm() + shape.radius + shape.length;
  }
}

}  // namespace

Hit cast(const SceneModel& model, const std::vector<Pose>& poses, const Ray& ray,
         RayTargets targets) {
  Hit hit;
  const Vec direction = widen(ray.direction).normalized();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.removed) continue;
    const Turn q_WB = widen(poses[b].q);
    const Vec p_WB = widen(poses[b].p);
    for (const Shape& shape : body.shapes) {
      const bool counts = (shape.visible && targets != RayTargets::colliding) ||
                          (shape.collides && targets != RayTargets::visible);
      if (!counts) continue;
      const Turn q_WS = q_WB * widen(shape.X_BS.q);
      const Vec to_origin = widen(ray.origin) - (p_WB + q_WB * widen(shape.X_BS.p));
      // Only an optimisation.
      const Real away = to_origin.cross(direction).norm();
      if (away > 1.001L * bounding_radius(model, shape)) continue;
      Line line{q_WS.conjugate() * to_origin, q_WS.conjugate() * direction,
                std::max(ray.min_distance, 0.0), ray.max_distance};
      offer_shape(line, model, shape);
      if (line.best < static_cast<Real>(hit.distance)) {
        hit.distance = static_cast<double>(line.best);
        hit.body = static_cast<int>(b);
      }
    }
  }
  return hit;
}

bool agrees(const SceneModel& model, const std::vector<Pose>& poses, const Ray& ray,
            double distance, RayTargets targets) {
  const auto close = [&](double low, double high) {
    if (std::isinf(distance) || std::isinf(low)) return distance >= low && distance <= high;
    return distance >= low - 1e-9 && distance <= high + 1e-9;
  };
  const double exact = cast(model, poses, ray, targets).distance;
  if (close(exact, exact)) return true;
  // Coordinates of size s are rounded to 1.1e-16 s, directions to 1.1e-16; some ten of these add
  // up.
  const double size = 1.0 + ray.origin.norm() + (std::isinf(exact) ? 0.0 : exact);
  double low = exact, high = exact;
  RandomStream random(1, "around");
  for (int i = 0; i < 48; ++i) {
    Ray moved = ray;
    moved.origin += 2e-15 * size * random_direction(random);
    moved.direction += 1e-15 * random_direction(random);
    const double there = cast(model, poses, moved, targets).distance;
    low = std::min(low, there);
    high = std::max(high, there);
  }
  return close(low, high);
}

SceneModelPtr mixed_bodies(int count, double extent, const Vec3& middle, std::uint64_t seed,
                           bool meshes) {
  ModelBuilder builder("mixed");
  RandomStream random(seed, "bodies");
  const auto size = [&] { return 0.2 + 1.3 * random.uniform(); };
  for (int i = 0; i < count; ++i) {
    const std::string name = "body_" + std::to_string(i);
    Pose pose = random_pose(random, extent);
    pose.p += middle;
    switch (i % (meshes ? 6 : 4)) {
      case 0: {
        const double x = size(), y = size();
        builder.box(name, {x, y, size()}, 1.0, pose);
        break;
      }
      case 1:
        builder.sphere(name, 0.5 * size(), 1.0, pose);
        break;
      case 2: {
        const double radius = 0.5 * size();
        builder.cylinder(name, radius, size(), 1.0, pose);
        break;
      }
      case 3: {
        const double radius = 0.25 * size();
        builder.capsule(name, radius, size(), 1.0, pose);
        break;
      }
      case 4: {
        const double radius = 0.5 * size();
        builder.mesh(name, ring(radius, 0.2), false, 0.0, pose);
        break;
      }
      default:
        builder.mesh(name, octahedron(0.5 * size()), true, 1.0, pose);
    }
  }
  return builder.build();
}

std::vector<Pose> poses_of(const SceneModel& model) {
  std::vector<Pose> poses;
  for (const Body& body : model.bodies) poses.push_back(body.X_WB);
  return poses;
}

Vec3 random_direction(RandomStream& random) {
  const double z = 2.0 * random.uniform() - 1.0, turn = 2.0 * kPi * random.uniform();
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return Vec3(r * std::cos(turn), r * std::sin(turn), z).normalized();
}

Vec3 random_point(RandomStream& random, double extent) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return extent * Vec3(2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0);
}

Pose random_pose(RandomStream& random, double extent) {
  const Vec3 axis = random_direction(random);
  const double angle = 2.0 * kPi * random.uniform();
  const Vec3 origin = random_point(random, extent);
  return {origin, Quat(Eigen::AngleAxisd(angle, axis))};
}

TriangleMesh ring(double radius, double thickness) {
  constexpr int kAround = 16, kAcross = 8;
  TriangleMesh mesh;
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double a = 2.0 * kPi * i / kAround, b = 2.0 * kPi * j / kAcross;
      const double r = radius + thickness * std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), thickness * std::sin(b));
      const int here = i * kAcross + j, across = i * kAcross + (j + 1) % kAcross;
      const int next = (i + 1) % kAround * kAcross;
      mesh.triangles.emplace_back(here, next + j, next + (j + 1) % kAcross);
      mesh.triangles.emplace_back(here, next + (j + 1) % kAcross, across);
    }
  }
  return mesh;
}

TriangleMesh octahedron(double radius) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) mesh.vertices.push_back(sign * radius * Vec3::Unit(axis));
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        const bool flip = (x + y + z) % 2 != 0;
        mesh.triangles.emplace_back(x, flip ? z : y, flip ? y : z);
      }
  return mesh;
}

}  // namespace cogrsim::reference
