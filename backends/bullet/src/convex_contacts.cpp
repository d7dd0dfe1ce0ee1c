#include "convex_contacts.h"

#include <algorithm>

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "box_axes.h"
#include "convert.h"
#include "face_clip.h"
#include "shape_factory.h"
#include "support_feature.h"

namespace cogrsim::bullet {

namespace {

// A direction of contact this near to a face's normal is the face's: distance queries know it to
// some 1e-6 rad only between faces that meet flush. (Cosine of 1e-3 rad.)
constexpr double kFlush = 1.0 - 5e-7;
// The closest points must be nearer than the corners by this much to be a point of their own [m];
// of a hull, which distance queries know to its size / 10216 only, by this part of its reach too.
constexpr double kNearer = 1e-5, kNearerHull = 2e-4;
// Feature number of the only point there is.
constexpr int kLone = 7;

struct Closest {
  bool found = false;
  PatchPoint point;
};

Closest closest_points(const CollisionShape& a, const btTransform& X_WA, const CollisionShape& b,
                       const btTransform& X_WB, double threshold) {
  const auto* shape_a = static_cast<const btConvexShape*>(a.shape.get());
  const auto* shape_b = static_cast<const btConvexShape*>(b.shape.get());
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth_solver;
  btGjkPairDetector detector(shape_a, shape_b, &simplex, &depth_solver);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = X_WA;
  input.m_transformB = X_WB;
  const double reach = threshold + shape_a->getMargin() + shape_b->getMargin();
  input.m_maximumDistanceSquared = reach * reach;
  btPointCollector result;
  detector.getClosestPoints(input, result, nullptr);
  Closest out;
  if (!result.m_hasResult || result.m_distance > threshold) return out;
  const btVector3& n = result.m_normalOnBInWorld;
  out.found = true;
  out.point = {result.m_pointInWorld + n * result.m_distance, result.m_pointInWorld, n,
               result.m_distance, kLone};
  return out;
}

double roughness(const Shape& shape, const CollisionShape& collision) {
  return shape.type == ShapeType::convex_mesh ? kNearerHull * collision.reach : 0.0;
}

btVector3 half_size(const Shape& box) { return to_bt(0.5 * box.size); }

}  // namespace

void convex_contacts(const Shape& a, const CollisionShape& collision_a, const btTransform& X_WA,
                     const Shape& b, const CollisionShape& collision_b, const btTransform& X_WB,
                     double threshold, ContactPatch& patch) {
  SupportFeature feature_a, feature_b;
  const auto clip = [&](const btVector3& normal) {
    find_support_feature(a, collision_a, X_WA, -normal, feature_a);
    find_support_feature(b, collision_b, X_WB, normal, feature_b);
    clip_features(feature_a, feature_b, normal, threshold, patch);
  };
  if (a.type == ShapeType::box && b.type == ShapeType::box) {
    btVector3 normal;
    if (!separating_axis(X_WA, half_size(a), X_WB, half_size(b), threshold, normal)) return;
    clip(normal);
    if (patch.size() > 0) return;
  }
  Closest closest = closest_points(collision_a, X_WA, collision_b, X_WB, threshold);
  if (!closest.found) return;
  if (a.type != ShapeType::sphere && b.type != ShapeType::sphere) {
    const btVector3& found = closest.point.normal;
    btVector3 normal = found, of_face;
    double most = kFlush;
    if (nearest_face_normal(b, collision_b, X_WB, found, of_face) && found.dot(of_face) > most) {
      most = found.dot(of_face);
      normal = of_face;
    }
    // B's face where both are as near, to rounding.
    if (nearest_face_normal(a, collision_a, X_WA, -found, of_face) &&
        -found.dot(of_face) > most + 1e-10) {
      normal = -of_face;
    }
    clip(normal);
  }
  double least = threshold;
  for (int i = 0; i < patch.size(); ++i) least = std::min(least, patch.point(i).distance);
  if (patch.size() == 0) {
    patch.add(closest.point);
  } else if (closest.point.distance <
             least - kNearer - roughness(a, collision_a) - roughness(b, collision_b)) {
    closest.point.feature = -1;
    patch.add(closest.point);
  }
}

}  // namespace cogrsim::bullet
