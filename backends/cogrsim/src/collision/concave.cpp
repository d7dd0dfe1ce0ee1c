#include <BulletCollision/CollisionShapes/btTriangleShape.h>

#include <algorithm>
#include <cmath>

#include "collision/narrowphase.h"

namespace cogrsim::dynamics {
namespace {

struct Triangle {
  Vec3 p[3];  // world
};

struct TriangleContact {
  Triangle triangle;
  Separation separation;
  bool on_face = false;
};

// Triangles that may touch, in the order the structure yields them.
struct Collector final : btTriangleCallback {
  void processTriangle(btVector3* t, int, int) override {
    Triangle out;
    for (int k = 0; k < 3; ++k) out.p[k] = Vec3(t[k].x(), t[k].y(), t[k].z());
    triangles.push_back(out);
  }
  std::vector<Triangle> triangles;
};

void collect_mesh(const Collider& mesh, const Vec3& low, const Vec3& high, Collector& out) {
  mesh.bvh->processAllTriangles(&out, btVector3(low[0], low[1], low[2]),
                                btVector3(high[0], high[1], high[2]));
}

void collect_heights(const HeightGrid& grid, const Vec3& low, const Vec3& high, Collector& out) {
  const double dx = grid.size_x / (grid.columns - 1), dy = grid.size_y / (grid.rows - 1);
  const auto cell = [](double x, double step, int count) {
    return std::clamp(int(std::floor(x / step)), 0, count - 2);
  };
  if (high[0] < -0.5 * grid.size_x || low[0] > 0.5 * grid.size_x) return;
  if (high[1] < -0.5 * grid.size_y || low[1] > 0.5 * grid.size_y) return;
  const int c0 = cell(low[0] + 0.5 * grid.size_x, dx, grid.columns);
  const int c1 = cell(high[0] + 0.5 * grid.size_x, dx, grid.columns);
  const int r0 = cell(low[1] + 0.5 * grid.size_y, dy, grid.rows);
  const int r1 = cell(high[1] + 0.5 * grid.size_y, dy, grid.rows);
  const auto corner = [&](int c, int r) {
    return Vec3(c * dx - 0.5 * grid.size_x, r * dy - 0.5 * grid.size_y,
                grid.heights[std::size_t(r * grid.columns + c)]);
  };
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) {
      const Vec3 a = corner(c, r), b = corner(c + 1, r), d = corner(c, r + 1),
                 e = corner(c + 1, r + 1);
      if (std::min({a[2], b[2], d[2], e[2]}) > high[2]) continue;
      if (std::max({a[2], b[2], d[2], e[2]}) < low[2] - std::max(dx, dy)) continue;
      out.triangles.push_back({{a, b, e}});
      out.triangles.push_back({{a, e, d}});
    }
  }
}

bool lies_on(const Triangle& t, const Vec3& n, const Vec3& p, double tolerance) {
  if (std::abs(n.dot(p - t.p[0])) > tolerance) return false;
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = t.p[(k + 1) % 3] - t.p[k];
    const double length = edge.norm();
    if (length > 0.0 && n.dot(edge.cross(p - t.p[k])) < -tolerance * length) return false;
  }
  return true;
}

Vec3 normal_of(const Triangle& t) { return (t.p[1] - t.p[0]).cross(t.p[2] - t.p[0]).normalized(); }

}  // namespace

void concave_contacts(const Collider& concave, const Collider& convex, double margin,
                      std::vector<ContactPoint>& out) {
  // Bounds of the convex shape in the mesh's frame.
  const Placement& X = concave.X_WS;
  const Vec3 centre = X.to_local(convex.X_WS.p);
  Vec3 low, high;
  for (int k = 0; k < 3; ++k) {
    high[k] = centre[k] + support_extent(convex, X.R.col(k)) + margin;
    low[k] = centre[k] - support_extent(convex, -X.R.col(k)) - margin;
  }
  Collector found;
  if (concave.type == ShapeType::mesh)
    collect_mesh(concave, low, high, found);
  else
    collect_heights(*concave.grid, low, high, found);

  constexpr double kOnFace = 1.0 - 1e-4;  // cosine between the normals of contact and triangle
  const btTransform X_convex = to_bullet(convex.X_WS);
  std::vector<TriangleContact> contacts;
  for (Triangle& t : found.triangles) {
    for (Vec3& p : t.p) p = X * p;
    const Vec3 n = normal_of(t);
    if (!n.allFinite()) continue;
    // From below a surface is not felt: what is under it came through, and is let out upwards.
    const double above = n.dot(convex.X_WS.p - t.p[0]);
    if (above < 0.0) continue;
    const double extent = support_extent(convex, -n);
    if (above - extent > margin) continue;
    btTriangleShape shape(btVector3(t.p[0][0], t.p[0][1], t.p[0][2]),
                          btVector3(t.p[1][0], t.p[1][1], t.p[1][2]),
                          btVector3(t.p[2][0], t.p[2][1], t.p[2][2]));
    shape.setMargin(0.0);
    TriangleContact c;
    c.triangle = t;
    c.separation =
        separate_convex(shape, btTransform::getIdentity(), *convex.convex, X_convex, margin);
    if (!c.separation.found || c.separation.normal.dot(n) <= 0.0) continue;
    // Where the triangle's own plane separates as well, it is the better witness.
    const double plane_gap = above - extent;
    c.on_face = c.separation.normal.dot(n) > kOnFace ||
                (plane_gap <= margin && plane_gap > c.separation.gap - 1e-7);
    if (c.on_face) {
      c.separation.normal = n;
      const Vec3 on_b = c.separation.on_b;
      c.separation.on_a = on_b - n * n.dot(on_b - t.p[0]);
      c.separation.gap = n.dot(on_b - t.p[0]);
    }
    contacts.push_back(c);
  }

  const std::size_t first = out.size();
  const double tolerance = 1e-4 * std::max(convex.reach, 1e-3);
  for (const TriangleContact& c : contacts) {
    if (!c.on_face) {
      // On an edge that belongs to a face which is touched itself: the face speaks for it.
      const bool spoken_for =
          std::any_of(contacts.begin(), contacts.end(), [&](const TriangleContact& face) {
            return face.on_face &&
                   lies_on(face.triangle, normal_of(face.triangle), c.separation.on_a, tolerance);
          });
      if (spoken_for) continue;
    }
    Feature on_a, on_b;
    for (const Vec3& p : c.triangle.p) on_a.add(p);
    support_feature(convex, -c.separation.normal, on_b);
    face_contacts(on_a, on_b, c.separation, margin, out);
  }

  // One group for each direction, at most four points in each; neighbours' doubles fall out.
  std::vector<ContactPoint> all(out.begin() + std::ptrdiff_t(first), out.end());
  out.resize(first);
  std::vector<char> used(all.size(), 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (used[i]) continue;
    const std::size_t group = out.size();
    for (std::size_t k = i; k < all.size(); ++k) {
      if (used[k] || all[k].normal.dot(all[i].normal) < 0.999) continue;
      used[k] = 1;
      const bool twice =
          std::any_of(out.begin() + std::ptrdiff_t(group), out.end(), [&](const ContactPoint& c) {
            return (c.point - all[k].point).squaredNorm() < tolerance * tolerance;
          });
      if (!twice) out.push_back(all[k]);
    }
    reduce_points(out, group);
  }
}

}  // namespace cogrsim::dynamics
