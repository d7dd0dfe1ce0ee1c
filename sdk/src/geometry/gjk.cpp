#include "geometry/gjk.h"

#include <limits>

namespace cogrsim::geometry {
namespace {

struct Nearest {
  Vec3 point;
  Simplex simplex;
};

Nearest on_point(const Vec3& a) {
  Nearest out{a, {}};
  out.simplex.points[0] = a;
  out.simplex.count = 1;
  return out;
}

Nearest on_segment(const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double t = -a.dot(ab), length = ab.squaredNorm();
  if (t <= 0.0 || length <= 0.0) return on_point(a);
  if (t >= length) return on_point(b);
  Nearest out{a + t / length * ab, {}};
  out.simplex.points = {a, b, Vec3::Zero(), Vec3::Zero()};
  out.simplex.count = 2;
  return out;
}

/// Of candidates, the nearer.
void keep(Nearest& best, const Nearest& other) {
  if (other.point.squaredNorm() < best.point.squaredNorm()) best = other;
}

Nearest on_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  const double area = n.squaredNorm();
  // Which side of every edge the origin is on, seen along n; inside of all: it projects on the face.
  const bool inside = area > 0.0 && n.dot(a.cross(b)) >= 0.0 && n.dot(b.cross(c)) >= 0.0 &&
                      n.dot(c.cross(a)) >= 0.0;
  if (inside) {
    Nearest out{a.dot(n) / area * n, {}};
    out.simplex.points = {a, b, c, Vec3::Zero()};
    out.simplex.count = 3;
    return out;
  }
  Nearest best = on_segment(a, b);
  keep(best, on_segment(b, c));
  keep(best, on_segment(c, a));
  return best;
}

Nearest on_tetrahedron(const std::array<Vec3, 4>& p) {
  Nearest best{Vec3::Constant(std::numeric_limits<double>::max()), {}};
  bool inside = true;
  constexpr std::size_t kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
  for (const auto& face : kFaces) {
    const Vec3 &a = p[face[0]], &b = p[face[1]], &c = p[face[2]], &d = p[face[3]];
    const Vec3 n = (b - a).cross(c - a);
    const double opposite = n.dot(d - a), origin = -n.dot(a);
    // On the far side of the face, or the tetrahedron is flat and has no inside.
    if (opposite * origin > 0.0) continue;
    inside = false;
    const Nearest here = on_triangle(a, b, c);
    if (here.simplex.count > 0) {
      if (best.simplex.count == 0) best = here;
      keep(best, here);
    }
  }
  if (!inside) return best;
  Nearest out{Vec3::Zero(), {}};
  out.simplex.points = p;
  out.simplex.count = 4;
  return out;
}

}  // namespace

Vec3 reduce(Simplex& simplex) {
  const auto& p = simplex.points;
  const Nearest found = simplex.count == 1   ? on_point(p[0])
                        : simplex.count == 2 ? on_segment(p[0], p[1])
                        : simplex.count == 3 ? on_triangle(p[0], p[1], p[2])
                                             : on_tetrahedron(p);
  simplex = found.simplex;
  return found.point;
}

}  // namespace cogrsim::geometry
