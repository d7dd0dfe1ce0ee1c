#include "rays/triangle_set.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/geometry/triangles.h"

namespace cogrsim::rays {
namespace {

/// Woop, Benthin, Wald: Watertight Ray/Triangle Intersection (JCGT 2(1), 2013), sections 3.1 to
/// 3.3, here in double precision. Corners are moved to the ray's origin and sheared so that the ray
/// runs along z; the areas between the ray and the two ends of an edge are then the same number
/// with opposite signs for both triangles at that edge. Unlike the paper both sides are hit.
class Shear {
 public:
  Shear(const Vec3& origin, const Vec3& direction) : origin_(origin) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    scale_ = 1.0 / direction[z_];
  }

  /// Distance along the ray; NaN: the line misses the triangle.
  double hit(const Vec3& corner_a, const Vec3& corner_b, const Vec3& corner_c) const {
    const Vec3 a = corner_a - origin_, b = corner_b - origin_, c = corner_c - origin_;
    const double ax = a[x_] - shear_x_ * a[z_], ay = a[y_] - shear_y_ * a[z_];
    const double bx = b[x_] - shear_x_ * b[z_], by = b[y_] - shear_y_ * b[z_];
    const double cx = c[x_] - shear_x_ * c[z_], cy = c[y_] - shear_y_ * c[z_];
    const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    const double none = std::numeric_limits<double>::quiet_NaN();
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return none;
    const double area = u + v + w;
    if (area == 0.0) return none;  // seen edge on, or without area
    return scale_ * (u * a[z_] + v * b[z_] + w * c[z_]) / area;
  }

 private:
  Vec3 origin_;
  int x_ = 0, y_ = 1, z_ = 2;
  double shear_x_, shear_y_, scale_;
};

}  // namespace

TriangleSet::TriangleSet(const TreeDevice& device, MeshPtr mesh)
    : mesh_(std::move(mesh)), tree_(device, false) {
  std::vector<geometry::Bounds> boxes;
  boxes.reserve(mesh_->triangles.size());
  for (std::size_t i = 0; i < mesh_->triangles.size(); ++i) {
    boxes.push_back(geometry::bounds_of(geometry::triangle(*mesh_, i)));
    box_.add(boxes.back());
  }
  if (boxes.empty()) box_.add(Vec3::Zero());
  tree_.build(boxes);
}

TriangleSet::Hit TriangleSet::nearest(const Vec3& origin, const Vec3& direction, double from,
                                      double to) const {
  struct Visitor final : BoxVisitor {
    Visitor(const TriangleSet& triangles, const Vec3& ray_origin, const Vec3& ray_direction)
        : set(triangles), shear(ray_origin, ray_direction) {}
    double visit(unsigned index) override {
      const geometry::Triangle t = geometry::triangle(*set.mesh_, index);
      const double distance = shear.hit(t[0], t[1], t[2]);
      const int number = static_cast<int>(index);
      if (distance >= from &&
          (distance < best.distance || (distance == best.distance && number < best.triangle))) {
        best = {distance, number};
      }
      return std::min(best.distance, to);
    }
    const TriangleSet& set;
    Shear shear;
    Hit best;
    double from = 0.0, to = 0.0;
  };
  Visitor visitor(*this, origin, direction);
  visitor.from = from;
  visitor.to = to;
  tree_.trace(origin, direction, from, to, visitor);
  return visitor.best.distance <= to ? visitor.best : Hit{};
}

Vec3 TriangleSet::normal(int triangle) const {
  const auto [a, b, c] = geometry::triangle(*mesh_, static_cast<std::size_t>(triangle));
  return (b - a).cross(c - a).stableNormalized();
}

}  // namespace cogrsim::rays
