#include <algorithm>
#include <cmath>

#include "collision/narrowphase.h"

namespace cogrsim::dynamics {
namespace {

class PlaneSink {
 public:
  PlaneSink(const Collider& plane, double margin, std::vector<ContactPoint>& out)
      : normal_(plane.X_WS.R.col(2)), origin_(plane.X_WS.p), margin_(margin), out_(out) {}

  const Vec3& normal() const { return normal_; }
  void add(const Vec3& p) {
    const double gap = normal_.dot(p - origin_);
    if (gap > margin_) return;
    ContactPoint c;
    c.normal = normal_;
    c.gap = gap;
    c.point = p - 0.5 * gap * normal_;
    out_.push_back(c);
  }

 private:
  Vec3 normal_, origin_;
  double margin_;
  std::vector<ContactPoint>& out_;
};

// Of the lower rim the lowest point, those a quarter turn away and the one opposite; of the upper
// rim the lowest. What is not near the plane falls out.
void cylinder_on_plane(const Collider& c, PlaneSink& sink) {
  const Mat3& R = c.X_WS.R;
  const Vec3 down = -(R.transpose() * sink.normal());
  const double across = std::hypot(down[0], down[1]);
  // Standing upright, any direction is lowest: one fixed in the body keeps the points where they were.
  const Vec3 x = across > 1e-6 ? Vec3(down[0] / across, down[1] / across, 0) : Vec3(1, 0, 0);
  const Vec3 y(-x[1], x[0], 0);
  const double z = down[2] >= 0 ? c.core.half.z() : -c.core.half.z();
  const Vec3 lower(0, 0, z), upper(0, 0, -z);
  sink.add(c.X_WS * (lower + c.core.radius * x));
  sink.add(c.X_WS * (upper + c.core.radius * x));
  if (across > 0.5) return;
  sink.add(c.X_WS * (lower + c.core.radius * y));
  sink.add(c.X_WS * (lower - c.core.radius * y));
  sink.add(c.X_WS * (lower - c.core.radius * x));
}

// Distance queries know hulls to their size / 10216 only.
double blur_of(const Collider& c) {
  return c.type == ShapeType::convex_mesh ? 2e-4 * c.bounding_radius : 0.0;
}

// Distance queries know the normal of faces that meet flush to some 1e-6 rad, other each time: a
// stack of nine pieces shuffles away on such normals, 0.3 m in 10 s. Those of the faces are exact.
void turn_flush(const Collider& a, const Collider& b, Separation& s) {
  constexpr double kFlush = 1.0 - 5e-7;  // cosine of 1e-3 rad
  const Vec3 found = s.normal;
  Vec3 of_face;
  double most = kFlush;
  if (face_normal(b, -found, of_face) && -found.dot(of_face) > most) {
    most = -found.dot(of_face);
    s.normal = -of_face;
  }
  // B's face where both are as near, to rounding.
  if (face_normal(a, found, of_face) && found.dot(of_face) > most + 1e-10) s.normal = of_face;
}

}  // namespace

void plane_contacts(const Collider& plane, const Collider& c, double margin,
                    std::vector<ContactPoint>& out) {
  PlaneSink sink(plane, margin, out);
  const Vec3& n = sink.normal();
  const std::size_t first = out.size();
  switch (c.type) {
    case ShapeType::box:
      for (int k = 0; k < 8; ++k)
        sink.add(c.X_WS * geometry::Bounds{-c.core.half, c.core.half}.corner(k));
      break;
    case ShapeType::sphere:
      sink.add(c.X_WS.p - c.core.margin * n);
      break;
    case ShapeType::cylinder:
      cylinder_on_plane(c, sink);
      break;
    case ShapeType::capsule:
      sink.add(c.X_WS * Vec3(-c.core.half) - c.core.margin * n);
      sink.add(c.X_WS * c.core.half - c.core.margin * n);
      break;
    case ShapeType::convex_mesh:
      for (const Vec3& v : c.hull->vertices) sink.add(c.X_WS * v);
      break;
    case ShapeType::plane:
    case ShapeType::mesh:
    case ShapeType::heightmap:
      break;
  }
  reduce_points(out, first);
}

void convex_contacts(const Collider& a, const Collider& b, double margin,
                     std::vector<ContactPoint>& out) {
  Separation s;
  if (a.type == ShapeType::sphere && b.type == ShapeType::sphere) {
    const Vec3 d = b.X_WS.p - a.X_WS.p;
    const double distance = d.norm();
    s.gap = distance - a.core.margin - b.core.margin;
    s.found = s.has_points = s.gap <= margin;
    s.normal = distance > 1e-12 ? Vec3(d / distance) : Vec3::UnitZ();
    s.on_a = a.X_WS.p + a.core.margin * s.normal;
    s.on_b = b.X_WS.p - b.core.margin * s.normal;
  } else if (a.type == ShapeType::box && b.type == ShapeType::box) {
    s = geometry::separate_boxes({a.core.half, a.X_WS}, {b.core.half, b.X_WS}, margin);
  } else {
    s = separate_convex(*a.convex, to_bullet(a.X_WS), *b.convex, to_bullet(b.X_WS), margin);
    s.blur = blur_of(a) + blur_of(b);
    if (s.found) turn_flush(a, b, s);
  }
  if (!s.found) return;
  Feature on_a, on_b;
  support_feature(a, s.normal, on_a);
  support_feature(b, -s.normal, on_b);
  const std::size_t first = out.size();
  face_contacts(on_a, on_b, s, margin, out);
  reduce_points(out, first);
}

}  // namespace cogrsim::dynamics
