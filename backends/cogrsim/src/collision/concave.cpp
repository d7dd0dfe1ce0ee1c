#include <BulletCollision/CollisionShapes/btTriangleShape.h>

#include <algorithm>
#include <cmath>

#include "cogrsim/geometry/triangles.h"
#include "collision/narrowphase.h"

namespace cogrsim::dynamics {
namespace {

using geometry::Bounds;
using geometry::Triangle;

struct TriangleContact {
  Triangle triangle;  // world
  Separation separation;
  bool on_face = false;
};

// Triangles that may touch, in the order the structure yields them.
struct Collector final : btTriangleCallback {
  void processTriangle(btVector3* t, int, int) override {
    const auto corner = [&](int k) { return Vec3(t[k].x(), t[k].y(), t[k].z()); };
    triangles.push_back({corner(0), corner(1), corner(2)});
  }
  std::vector<Triangle> triangles;
};

void collect_mesh(const Collider& mesh, const Bounds& where, Collector& out) {
  const Vec3 &low = where.low, &high = where.high;
  mesh.bvh->processAllTriangles(&out, btVector3(low[0], low[1], low[2]),
                                btVector3(high[0], high[1], high[2]));
}

bool lies_on(const Triangle& t, const Vec3& n, const Vec3& p, double tolerance) {
  if (std::abs(n.dot(p - t[0])) > tolerance) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = t[(k + 1) % 3] - t[k];
    const double length = edge.norm();
    if (length > 0.0 && n.dot(edge.cross(p - t[k])) < -tolerance * length) return false;
  }
  return true;
}

Vec3 normal_of(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }

// Triangles of the mesh near the convex shape, in the world.
std::vector<Triangle> triangles_near(const Collider& concave, const Collider& convex,
                                     double margin) {
  // Bounds of the convex shape in the mesh's frame.
  const Placement& X = concave.X_WS;
  const Vec3 centre = X.to_local(convex.X_WS.p);
  Bounds where;
  for (int k = 0; k < 3; ++k) {
    where.high[k] = centre[k] + support_extent(convex, X.R.col(k)) + margin;
    where.low[k] = centre[k] - support_extent(convex, -X.R.col(k)) - margin;
  }
  Collector found;
  if (concave.type == ShapeType::mesh)
    collect_mesh(concave, where, found);
  else
    geometry::for_triangles(*concave.grid, where, [&](const Triangle& t) {
      if (!geometry::bounds_of(t).disjoint(where)) found.triangles.push_back(t);
    });
  for (Triangle& t : found.triangles)
    for (Vec3& p : t) p = X * p;
  return std::move(found.triangles);
}

bool find_triangle_contact(const Triangle& t, const Collider& convex, const btTransform& X_convex,
                           double margin, TriangleContact& out) {
  constexpr double kOnFace = 1.0 - 1e-4;  // cosine between the normals of contact and triangle
  const Vec3 n = normal_of(t);
  if (!n.allFinite()) return false;
  // A surface has no contact from below: what is under it passed through and may leave upwards.
  const double above = n.dot(convex.X_WS.p - t[0]);
  if (above < 0.0) return false;
  const double extent = support_extent(convex, -n);
  if (above - extent > margin) return false;
  btTriangleShape shape(btVector3(t[0][0], t[0][1], t[0][2]), btVector3(t[1][0], t[1][1], t[1][2]),
                        btVector3(t[2][0], t[2][1], t[2][2]));
  shape.setMargin(0.0);
  out.triangle = t;
  Separation& separation = out.separation;
  separation = separate_convex(shape, btTransform::getIdentity(), *convex.convex, X_convex, margin);
  if (!separation.found || separation.normal.dot(n) <= 0.0) return false;
  // Where the triangle's own plane separates as well, its normal and gap are more exact.
  const double plane_gap = above - extent;
  out.on_face = separation.normal.dot(n) > kOnFace ||
                (plane_gap <= margin && plane_gap > separation.gap - 1e-7);
  if (out.on_face) {
    separation.normal = n;
    separation.on_a = separation.on_b - n * n.dot(separation.on_b - t[0]);
    separation.gap = n.dot(separation.on_b - t[0]);
  }
  return true;
}

// Whether a contact is on an edge of a face that is touched itself: the face's contact replaces it.
bool is_replaced(const TriangleContact& c, const std::vector<TriangleContact>& contacts,
                 double tolerance) {
  return !c.on_face &&
         std::any_of(contacts.begin(), contacts.end(), [&](const TriangleContact& face) {
           return face.on_face &&
                  lies_on(face.triangle, normal_of(face.triangle), c.separation.on_a, tolerance);
         });
}

// Groups the points of `all` by normal, with at most four in each; doubles of neighbours are dropped.
void add_grouped(const std::vector<ContactPoint>& all, double tolerance,
                 std::vector<ContactPoint>& out) {
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

}  // namespace

void concave_contacts(const Collider& concave, const Collider& convex, double margin,
                      std::vector<ContactPoint>& out) {
  const btTransform X_convex = to_bullet(convex.X_WS);
  std::vector<TriangleContact> contacts;
  for (const Triangle& t : triangles_near(concave, convex, margin)) {
    TriangleContact c;
    if (find_triangle_contact(t, convex, X_convex, margin, c)) contacts.push_back(c);
  }
  const double tolerance = 1e-4 * std::max(convex.bounding_radius, 1e-3);
  std::vector<ContactPoint> points;
  for (const TriangleContact& c : contacts) {
    if (is_replaced(c, contacts, tolerance)) continue;
    Feature on_a, on_b;
    for (const Vec3& p : c.triangle) on_a.add(p);
    support_feature(convex, -c.separation.normal, on_b);
    face_contacts(on_a, on_b, c.separation, margin, points);
  }
  add_grouped(points, tolerance, out);
}

}  // namespace cogrsim::dynamics
