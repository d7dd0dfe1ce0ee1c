#include "cogrsim/geometry/convex.h"

#include <algorithm>
#include <cmath>

#include "geometry/gjk.h"

namespace cogrsim::geometry {
namespace {

/// Nearest distance of two segments p ± a and q ± b (Ericson, Real-Time Collision Detection, 5.1.9).
double segment_distance(const Vec3& p, const Vec3& a, const Vec3& q, const Vec3& b) {
  const Vec3 d1 = 2 * a, d2 = 2 * b, r = (p - a) - (q - b);
  const double aa = d1.squaredNorm(), ee = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r);
  if (aa <= 0.0 || ee <= 0.0) {  // one is a point: project it
    const double s = aa > 0.0 ? std::clamp(-c / aa, 0.0, 1.0) : 0.0;
    const double t = ee > 0.0 ? std::clamp(f / ee, 0.0, 1.0) : 0.0;
    return (r + s * d1 - t * d2).norm();
  }
  const double bb = d1.dot(d2), denominator = aa * ee - bb * bb;
  double s =
      denominator > 1e-12 * aa * ee ? std::clamp((bb * f - c * ee) / denominator, 0.0, 1.0) : 0.0;
  double t = (bb * s + f) / ee;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((bb * t - c) / aa, 0.0, 1.0);
  }
  return (r + s * d1 - t * d2).norm();
}

}  // namespace

Vec3 Core::support(const Vec3& d) const {
  switch (kind) {
    case Kind::point:
      return Vec3::Zero();
    case Kind::segment:
      return {0, 0, std::copysign(half.z(), d.z())};
    case Kind::box:
      return {std::copysign(half.x(), d.x()), std::copysign(half.y(), d.y()),
              std::copysign(half.z(), d.z())};
    case Kind::cylinder: {
      const double r = std::hypot(d.x(), d.y());
      const double s = r > 0.0 ? radius / r : 0.0;
      return {s * d.x(), s * d.y(), std::copysign(half.z(), d.z())};
    }
    case Kind::points:
      break;
  }
  std::size_t best = 0;
  double furthest = -kInfinity;
  for (std::size_t i = 0; i < count; ++i) {
    const double along = points[i].dot(d);
    if (along > furthest) furthest = along, best = i;
  }
  return points[best];
}

double Core::extent(const Vec3& d) const {
  switch (kind) {
    case Kind::point:
      return margin;
    case Kind::segment:
      return margin + half.z() * std::abs(d.z());
    case Kind::box:
      return d.cwiseAbs().dot(half);
    case Kind::cylinder:
      return radius * std::hypot(d.x(), d.y()) + half.z() * std::abs(d.z());
    case Kind::points:
      break;
  }
  double most = -kInfinity;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, points[i].dot(d));
  return most;
}

Vec3 Core::half_extents(const Mat3& R) const {
  switch (kind) {
    case Kind::segment:
      return half.z() * R.col(2).cwiseAbs() + Vec3::Constant(margin);
    case Kind::box:
      return R.cwiseAbs() * half;
    case Kind::cylinder:
      return half.z() * R.col(2).cwiseAbs() +
             radius * (Vec3::Ones() - R.col(2).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    case Kind::point:
    case Kind::points:
      break;
  }
  return Vec3::Constant(margin);
}

std::optional<Vec3> Core::nearest(const Vec3& p) const {
  switch (kind) {
    case Kind::point:
      return Vec3(Vec3::Zero());
    case Kind::segment:
    case Kind::box:
      return Vec3(p.cwiseMax(-half).cwiseMin(half));
    case Kind::cylinder: {
      const double r = std::hypot(p.x(), p.y());
      const double s = r > radius ? radius / r : 1.0;
      return Vec3(s * p.x(), s * p.y(), std::clamp(p.z(), -half.z(), half.z()));
    }
    case Kind::points:
      break;
  }
  return std::nullopt;
}

Bounds Core::bounds(const Pose& X) const {
  if (kind != Kind::points) {
    const Vec3 extents = half_extents(X.q.toRotationMatrix());
    return {X.p - extents, X.p + extents};
  }
  Bounds out;
  for (std::size_t i = 0; i < count; ++i) out.add(X * points[i]);
  return out;
}

Core core_of(const SceneModel& model, const Shape& shape) {
  Core core;
  const Vec3 end = 0.5 * shape.length * Vec3::UnitZ();
  switch (shape.type) {
    case ShapeType::box:
      core.kind = Core::Kind::box;
      core.half = 0.5 * shape.size;
      break;
    case ShapeType::sphere:
      core.margin = shape.radius;
      break;
    case ShapeType::capsule:
      core.kind = Core::Kind::segment;
      core.half = end;
      core.margin = shape.radius;
      break;
    case ShapeType::cylinder:
      core.kind = Core::Kind::cylinder;
      core.half = end;
      core.radius = shape.radius;
      break;
    default: {
      const auto& vertices = model.meshes[shape.mesh]->vertices;
      core.kind = Core::Kind::points;
      core.points = vertices.data();
      core.count = vertices.size();
    }
  }
  return core;
}

Core core_of(const Vec3* corners) {
  Core core;
  core.kind = Core::Kind::points;
  core.points = corners;
  core.count = 3;
  return core;
}

Bounds local_bounds(const SceneModel& model, const Shape& shape) {
  switch (shape.type) {
    case ShapeType::plane:
      return {Vec3::Constant(-kInfinity), {kInfinity, kInfinity, 0.0}};
    case ShapeType::heightmap: {
      const HeightGrid& grid = *model.heightmaps[shape.heightmap];
      const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
      return {{-0.5 * grid.size_x, -0.5 * grid.size_y, *low},
              {0.5 * grid.size_x, 0.5 * grid.size_y, *high}};
    }
    default:
      return core_of(model, shape).bounds({});
  }
}

double bounding_radius(const SceneModel& model, const Shape& shape) {
  if (shape.type == ShapeType::plane) return kInfinity;
  if (shape.type == ShapeType::heightmap) {
    const Bounds box = local_bounds(model, shape);
    return box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs()).norm();
  }
  const Core core = core_of(model, shape);
  double square = 0.0;
  for (std::size_t i = 0; i < core.count; ++i)
    square = std::max(square, core.points[i].squaredNorm());
  if (core.kind == Core::Kind::points) return std::sqrt(square);
  if (core.kind == Core::Kind::cylinder) return std::hypot(core.radius, core.half.z());
  return core.half.norm() + core.margin;
}

Ball bounding_ball(const SceneModel& model, const Shape& shape) {
  if (shape.mesh < 0 && shape.heightmap < 0) return {Vec3::Zero(), bounding_radius(model, shape)};
  const Bounds box = local_bounds(model, shape);
  Ball out{box.middle(), box.half().norm()};
  if (shape.mesh < 0) return out;
  const Core points = core_of(model, shape);
  out.radius = 0.0;
  for (std::size_t i = 0; i < points.count; ++i)
    out.radius = std::max(out.radius, (points.points[i] - out.middle).norm());
  return out;
}

Vec3 core_gap(const Placed& a, const Placed& b) {
  // About a point near both, so that coordinates are small.
  const Vec3 origin = 0.5 * (a.X_WS.p + b.X_WS.p);
  const Pose X_a{a.X_WS.p - origin, a.X_WS.q}, X_b{b.X_WS.p - origin, b.X_WS.q};
  const Placed A{a.core, X_a}, B{b.core, X_b};
  const auto difference = [&](const Vec3& d) -> Vec3 { return A.support(d) - B.support(-d); };
  return nearest_to_origin(difference, difference(X_b.p - X_a.p));
}

double core_distance(const Placed& a, const Placed& b) {
  using Kind = Core::Kind;
  if (a.core.kind == Kind::point || b.core.kind == Kind::point) {
    const Placed& point = a.core.kind == Kind::point ? a : b;
    const Placed& other = a.core.kind == Kind::point ? b : a;
    const Vec3 p = other.X_WS.inverse() * point.X_WS.p;
    if (const auto near = other.core.nearest(p)) return (p - *near).norm();
  }
  if (a.core.kind == Kind::segment && b.core.kind == Kind::segment)
    return segment_distance(a.X_WS.p, a.X_WS.q * a.core.half, b.X_WS.p, b.X_WS.q * b.core.half);
  return core_gap(a, b).norm();
}

}  // namespace cogrsim::geometry
