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

// How much the gap along `n`, from a to b, will have grown by the end of the step [m].
double growth_of_gap(const Collider& a, const Collider& b, const Vec3& n) {
  const Vec3 at = a.bounding_radius < b.bounding_radius
                      ? Vec3(a.X_WS.p + support_extent(a, n) * n)
                      : Vec3(b.X_WS.p - support_extent(b, -n) * n);
  return n.dot(b.travel_of(at) - a.travel_of(at));
}

// Whether the shapes of distance queries are farther apart than those could mistake: then a query would
// find nothing. In a step a gap along a direction becomes less by no more than the shapes move.
bool are_apart(const Collider& a, const Collider& b, double margin, Apart& apart) {
  constexpr double kMistake = 1e-3;  // of the distance
  const double least = margin + kMistake * (margin + a.bounding_radius + b.bounding_radius);
  const Vec3& n = apart.axis;
  if (n.isZero(0.0)) return false;
  apart.gap -= a.moved + b.moved;
  if (apart.gap > least) return true;
  const auto reach = [](const Collider& c, const Vec3& d) {
    const Vec3 local = c.X_WS.R.transpose() * d;
    const btVector3 v =
        c.convex->localGetSupportingVertexWithoutMargin({local[0], local[1], local[2]});
    return local.dot(Vec3(v.x(), v.y(), v.z())) + c.convex->getMargin();
  };
  apart.gap = n.dot(b.X_WS.p - a.X_WS.p) - reach(a, n) - reach(b, -n);
  return apart.gap > least;
}

// Convex shapes touch where the last of the gaps along all axes closes. One that slides over a face
// comes upon the side of the next: that gap is open and about to close, but the one along the face,
// which has long been closed, would still hardly overlap by then. Contact is along the axis on which they overlap
// least at the end of the step; what overlaps by more than kFlush before is no longer flush.
Separation flush_separation(const Collider& a, const Collider& b, double margin,
                            const Separation& found) {
  constexpr double kFlush = 1e-4;  // faces of which one stands out by less are one [m]
  // A gap of less by the end of a step may stop a body: twice kTouching in rows.cpp [m].
  constexpr double kClosed = 2e-5;
  const auto gap_along = [&](const Vec3& n) {
    return n.dot(b.X_WS.p - a.X_WS.p) - support_extent(a, n) - support_extent(b, -n);
  };
  // At the end of the step; one that is still open and only just not closed counts as closed.
  const auto end_of = [&](double gap, const Vec3& n) {
    return gap + growth_of_gap(a, b, n) - (gap > 0.0 ? kClosed : 0.0);
  };
  if (found.gap < -kFlush) return found;
  // Distance queries round edges: past one, where faces overlap already, they find a gap still.
  double most = end_of(std::min(found.gap, gap_along(found.normal)), found.normal);
  if (most >= 0.0) return found;
  Separation best = found;
  const auto consider = [&](const Vec3& n) {
    const double gap = gap_along(n);
    if (gap < -kFlush) return;
    const double end = end_of(gap, n);
    if (end <= most) return;
    most = end;
    best = Separation();
    best.found = gap <= margin;
    best.normal = n;
    best.gap = gap;
  };
  // The gap along a face's normal is no more than the height over it of any point of the other shape.
  constexpr double kLeast = -kFlush - 1e-9;
  for_face_normals(a, b.X_WS.p, support_point(b, -found.normal), kLeast, consider);
  for_face_normals(b, a.X_WS.p, support_point(a, found.normal), kLeast,
                   [&](const Vec3& n) { consider(-n); });
  return best;
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

void convex_contacts(const Collider& a, const Collider& b, double margin, Apart& apart,
                     std::vector<ContactPoint>& out) {
  if (a.type == ShapeType::sphere && b.type == ShapeType::sphere) {
    const Vec3 d = b.X_WS.p - a.X_WS.p;
    const double distance = d.norm();
    ContactPoint c;
    c.gap = distance - a.core.margin - b.core.margin;
    if (!(c.gap <= margin)) return;  // nor where it is no number
    c.normal = distance > 1e-12 ? Vec3(d / distance) : Vec3::UnitZ();
    c.point = a.X_WS.p + (a.core.margin + 0.5 * c.gap) * c.normal;
    out.push_back(c);
    return;
  }
  Separation s;
  if (a.type == ShapeType::box && b.type == ShapeType::box) {
    s = geometry::separate_boxes({a.core.half, a.X_WS}, {b.core.half, b.X_WS}, margin);
  } else {
    if (are_apart(a, b, margin, apart)) return;
    apart = Apart();
    s = separate_convex(*a.convex, to_bullet(a.X_WS), *b.convex, to_bullet(b.X_WS), margin,
                        &apart.axis);
    s.blur = blur_of(a) + blur_of(b);
    if (s.found) turn_flush(a, b, s);
  }
  if (!s.found) return;
  const std::size_t first = out.size();
  const auto add = [&](const Separation& separation) {
    Feature on_a, on_b;
    support_feature(a, separation.normal, on_a);
    support_feature(b, -separation.normal, on_b);
    face_contacts(on_a, on_b, separation, margin, out);
  };
  const Separation flush = flush_separation(a, b, margin, s);
  if (flush.found) add(flush);
  // What touches already is not passed over.
  if (out.size() == first && s.gap <= 0.0) add(s);
  reduce_points(out, first);
}

}  // namespace cogrsim::dynamics
