#include "plane_contacts.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "convert.h"
#include "shape_factory.h"

namespace cogrsim::bullet {

namespace {

/// Calls visit(point on the shape, distance, feature) for every point plane_contacts() promises.
template <class Visitor>
void visit_near_plane(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                      const HalfSpace& plane, double threshold, Visitor&& visit) {
  const btVector3& c = X_WS.getOrigin();
  const btMatrix3x3& R = X_WS.getBasis();
  const btVector3& n = plane.normal;
  const double centre = n.dot(c) - plane.offset;
  const auto offer = [&](const btVector3& from_centre, int feature) {
    const double distance = centre + n.dot(from_centre);
    if (distance < threshold) visit(c + from_centre, distance, feature);
  };
  switch (shape.type) {
    case ShapeType::sphere:
      offer(n * -shape.radius, 0);
      break;
    case ShapeType::capsule: {
      const btVector3 half = R.getColumn(2) * (0.5 * shape.length);
      offer(half - n * shape.radius, 0);
      offer(-half - n * shape.radius, 1);
      break;
    }
    case ShapeType::box: {
      const btVector3 along = n * R;  // n in the box's axes
      const int face = along.absolute().maxAxis();
      const int u = (face + 1) % 3, v = (face + 2) % 3;
      const double side = along[face] > 0.0 ? -0.5 : 0.5;
      const btVector3 middle = R.getColumn(face) * (side * shape.size[face]);
      const btVector3 du = R.getColumn(u) * (0.5 * shape.size[u]);
      const btVector3 dv = R.getColumn(v) * (0.5 * shape.size[v]);
      const int base = 8 * face + (side > 0.0 ? 4 : 0);
      offer(middle - du - dv, base);
      offer(middle + du - dv, base + 1);
      offer(middle + du + dv, base + 2);
      offer(middle - du + dv, base + 3);
      break;
    }
    case ShapeType::cylinder: {
      const btVector3 axis = R.getColumn(2);
      const double cosine = n.dot(axis);
      btVector3 down = axis * cosine - n;  // across the axis, towards the plane
      const double sine = down.length();
      const btVector3 half = axis * (0.5 * shape.length);
      if (std::abs(cosine) < 0.7) {
        down *= shape.radius / sine;
        // Both rims, and the middle: it is what rolls without slip while a wheel turns on the
        // spot and the rims slide opposite ways. With rims alone the heavier one would hold.
        offer(half + down, 0);
        offer(-half + down, 1);
        offer(down, 6);
        break;
      }
      // Standing: the lowest point of the lower rim and three more a quarter turn apart.
      down = sine > 1e-6 ? btVector3(down * (shape.radius / sine)) : R.getColumn(0) * shape.radius;
      const btVector3 end = cosine > 0.0 ? -half : half;
      const btVector3 across = axis.cross(down);
      offer(end + down, 2);
      offer(end + across, 3);
      offer(end - down, 4);
      offer(end - across, 5);
      break;
    }
    case ShapeType::convex_mesh:
      for (std::size_t i = 0; i < collision.faces.vertices.size(); ++i)
        offer(R * to_bt(collision.faces.vertices[i]), static_cast<int>(i));
      break;
    default:
      break;
  }
}

}  // namespace

void plane_contacts(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                    const HalfSpace& plane, double threshold, ContactPatch& patch) {
  visit_near_plane(
      shape, collision, X_WS, plane, threshold,
      [&](const btVector3& point, double distance, int feature) {
        patch.add({point, point - plane.normal * distance, plane.normal, distance, feature});
      });
}

namespace {

// A closest-point normal within this angle of the face's counts as the face's [rad].
constexpr double kFaceCosine = 0.985;

/// Whether the projection of p lies over the triangle; edges count, by `slack` [m].
bool over_triangle(const btVector3* t, const btVector3& n, const btVector3& p, double slack) {
  for (int i = 0; i < 3; ++i) {
    const btVector3 edge = t[(i + 1) % 3] - t[i];
    const btVector3 outward = edge.cross(n);
    const double length = edge.length();
    if (outward.dot(p - t[i]) > slack * length) return false;
  }
  return true;
}

class TriangleVisitor final : public btTriangleCallback {
 public:
  TriangleVisitor(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                  const btTransform& X_WC, double threshold, ContactPatch& patch, bool terrain,
                  std::vector<NearTriangle>& open)
      : terrain_(terrain),
        shape_(shape),
        collision_(collision),
        X_WS_(X_WS),
        X_WC_(X_WC),
        threshold_(threshold),
        patch_(patch),
        open_(open) {
    open_.clear();
  }

  void processTriangle(btVector3* local, int, int) override {
    btVector3 t[3] = {X_WC_ * local[0], X_WC_ * local[1], X_WC_ * local[2]};
    btVector3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    if (terrain_ && n.dot(X_WC_.getBasis().getColumn(2)) < 0.0) {
      // Bullet winds a heightfield's triangles either way; its outer side is up.
      btSwap(t[1], t[2]);
      n = -n;
    }
    const double area = n.length();
    if (area <= 0.0) return;
    n /= area;
    const double height = n.dot(X_WS_.getOrigin() - t[0]);
    if (height < 0.0 || height - collision_.reach > threshold_) return;
    const HalfSpace plane{n, n.dot(t[0])};
    bool found = false, near = false;
    const double slack = 1e-9 * std::sqrt(area);
    visit_near_plane(shape_, collision_, X_WS_, plane, threshold_,
                     [&](const btVector3& point, double distance, int) {
                       near = true;
                       if (!over_triangle(t, n, point, slack)) return;
                       patch_.add({point, point - n * distance, n, distance, -1});
                       found = true;
                     });
    // A sphere over the face needs no more; other shapes may still lie on an edge of it.
    if (!near || (found && shape_.type == ShapeType::sphere)) return;
    open_.push_back({{t[0], t[1], t[2]}, n});
  }

  /// After all triangles: the edges and corners of those that may be touched beside a face.
  void finish() {
    const int faces = patch_.size();
    for (const NearTriangle& triangle : open_) closest_points(triangle, faces);
  }

 private:
  void closest_points(const NearTriangle& near, int faces) {
    const btVector3* t = near.corners;
    const btVector3& n = near.normal;
    btTriangleShape triangle(t[0], t[1], t[2]);
    triangle.setMargin(0.0);
    const auto* convex = static_cast<const btConvexShape*>(collision_.shape.get());
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth_solver;
    btGjkPairDetector detector(convex, &triangle, &simplex, &depth_solver);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = X_WS_;
    input.m_transformB.setIdentity();
    const double reach = threshold_ + convex->getMargin();
    input.m_maximumDistanceSquared = reach * reach;
    btPointCollector result;
    detector.getClosestPoints(input, result, nullptr);
    if (!result.m_hasResult || result.m_distance > threshold_) return;
    btVector3 normal = result.m_normalOnBInWorld;
    const double cosine = normal.dot(n);
    if (cosine < 0.05) return;  // from behind
    double distance = result.m_distance;
    // A seam ahead of a rolling wheel is no contact where a face below already carries.
    for (int i = 0; i < faces; ++i) {
      const PatchPoint& face = patch_.point(i);
      if (face.normal.dot(normal) > kFaceCosine && face.distance <= distance + 1e-7) return;
    }
    const btVector3 on_a = result.m_pointInWorld + normal * distance;
    if (cosine > kFaceCosine) {
      normal = n;
      distance = n.dot(on_a - t[0]);
    }
    patch_.add({on_a, on_a - normal * distance, normal, distance, -1});
  }

  bool terrain_;
  const Shape& shape_;
  const CollisionShape& collision_;
  const btTransform& X_WS_;
  const btTransform& X_WC_;
  double threshold_;
  ContactPatch& patch_;
  std::vector<NearTriangle>& open_;
};

}  // namespace

void surface_contacts(const Shape& shape, const CollisionShape& collision, const btTransform& X_WS,
                      const CollisionShape& surface, const btTransform& X_WC, double threshold,
                      ContactPatch& patch, std::vector<NearTriangle>& scratch) {
  btVector3 low, high;
  collision.shape->getAabb(X_WC.inverseTimes(X_WS), low, high);
  const btVector3 extra(threshold, threshold, threshold);
  TriangleVisitor visitor(shape, collision, X_WS, X_WC, threshold, patch,
                          surface.shape->getShapeType() == TERRAIN_SHAPE_PROXYTYPE, scratch);
  static_cast<const btConcaveShape*>(surface.shape.get())
      ->processAllTriangles(&visitor, low - extra, high + extra);
  visitor.finish();
}

}  // namespace cogrsim::bullet
