#include "geometry/solids.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim::geometry {
namespace {

/// Cuts `crossing` to where |o + t d| <= half; false: nothing is left.
bool cut_to_slab(Crossing& crossing, double o, double d, double half, int face) {
  if (d == 0.0) return std::abs(o) <= half;
  const double low = ((d > 0.0 ? -half : half) - o) / d;
  const double high = ((d > 0.0 ? half : -half) - o) / d;
  if (low > crossing.in) {
    crossing.in = low;
    crossing.in_face = face;
  }
  if (high < crossing.out) {
    crossing.out = high;
    crossing.out_face = face;
  }
  return crossing.in <= crossing.out;
}

/// Roots of |o + t d| = r in the plane z = 0: a t^2 + 2 b t + c = 0. The discriminant is formed
/// from the distance to the axis, (o x d)^2, which loses nothing when the line passes close to it.
std::optional<Crossing> cross_infinite_cylinder(const Vec3& o, const Vec3& d, double radius) {
  const double a = d.x() * d.x() + d.y() * d.y();
  if (a == 0.0) {
    if (o.x() * o.x() + o.y() * o.y() > radius * radius) return {};
    return Crossing{-kInfinity, kInfinity, 0, 0};
  }
  const double cross = o.x() * d.y() - o.y() * d.x();
  const double discriminant = radius * radius * a - cross * cross;
  if (!(discriminant >= 0.0)) return {};
  const double b = o.x() * d.x() + o.y() * d.y(), root = std::sqrt(discriminant);
  return Crossing{(-b - root) / a, (-b + root) / a, 0, 0};
}

std::optional<Crossing> cross_sphere(const Vec3& o, const Vec3& d, double radius) {
  const double nearest = -o.dot(d);
  const double square = radius * radius - (o + nearest * d).squaredNorm();
  if (!(square >= 0.0)) return {};
  const double half = std::sqrt(square);
  return Crossing{nearest - half, nearest + half, 0, 0};
}

std::optional<Crossing> cross_box(const Vec3& o, const Vec3& d, const Vec3& size) {
  Crossing crossing{-kInfinity, kInfinity, 0, 0};
  for (int axis = 0; axis < 3; ++axis)
    if (!cut_to_slab(crossing, o[axis], d[axis], 0.5 * size[axis], axis)) return {};
  return crossing;
}

std::optional<Crossing> cross_cylinder(const Vec3& o, const Vec3& d, double radius, double length) {
  auto crossing = cross_infinite_cylinder(o, d, radius);
  if (crossing && !cut_to_slab(*crossing, o.z(), d.z(), 0.5 * length, 1)) return {};
  return crossing;
}

// A capsule is a cylinder and two spheres, and convex: what is inside of any of them is one piece.
std::optional<Crossing> cross_capsule(const Vec3& o, const Vec3& d, double radius, double length) {
  std::optional<Crossing> whole;
  const auto join = [&](const std::optional<Crossing>& part) {
    if (!part) return;
    if (!whole) whole = Crossing{part->in, part->out, 0, 0};
    whole->in = std::min(whole->in, part->in);
    whole->out = std::max(whole->out, part->out);
  };
  const Vec3 end(0.0, 0.0, 0.5 * length);
  join(cross_cylinder(o, d, radius, length));
  join(cross_sphere(o - end, d, radius));
  join(cross_sphere(o + end, d, radius));
  return whole;
}

}  // namespace

std::optional<Crossing> cross_solid(const Shape& shape, const Vec3& origin, const Vec3& direction) {
  switch (shape.type) {
    case ShapeType::box:
      return cross_box(origin, direction, shape.size);
    case ShapeType::sphere:
      return cross_sphere(origin, direction, shape.radius);
    case ShapeType::cylinder:
      return cross_cylinder(origin, direction, shape.radius, shape.length);
    case ShapeType::capsule:
      return cross_capsule(origin, direction, shape.radius, shape.length);
    default:
      return {};
  }
}

Vec3 solid_normal(const Shape& shape, const Vec3& point, int face) {
  switch (shape.type) {
    case ShapeType::box: {
      Vec3 normal = Vec3::Zero();
      normal[face] = point[face] < 0.0 ? -1.0 : 1.0;
      return normal;
    }
    case ShapeType::cylinder:
      if (face == 1) return {0.0, 0.0, point.z() < 0.0 ? -1.0 : 1.0};
      return Vec3(point.x(), point.y(), 0.0).normalized();
    case ShapeType::capsule: {
      const double half = 0.5 * shape.length;
      return Vec3(point.x(), point.y(), point.z() - std::clamp(point.z(), -half, half))
          .normalized();
    }
    default:
      return point.normalized();
  }
}

}  // namespace cogrsim::geometry
