#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "collision/narrowphase.h"

namespace cogrsim::dynamics {
namespace {

struct Sink final : btDiscreteCollisionDetectorInterface::Result {
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3& normal_on_b, const btVector3& on_b,
                       btScalar distance) override {
    separation.found = separation.has_points = true;
    const Vec3 n(normal_on_b.x(), normal_on_b.y(), normal_on_b.z());
    separation.normal = -n.normalized();
    separation.gap = distance;
    separation.on_b = Vec3(on_b.x(), on_b.y(), on_b.z());
    separation.on_a = separation.on_b - distance * separation.normal;
  }
  Separation separation;
};

}  // namespace

btTransform to_bullet(const Placement& X) {
  const Mat3& R = X.R;
  return btTransform(
      btMatrix3x3(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
      btVector3(X.p[0], X.p[1], X.p[2]));
}

Separation separate_convex(const btConvexShape& a, const btTransform& X_a, const btConvexShape& b,
                           const btTransform& X_b, double margin, Vec3* axis) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver penetration;
  btGjkPairDetector detector(&a, &b, &simplex, &penetration);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA = X_a;
  input.m_transformB = X_b;
  const double most = a.getMargin() + b.getMargin() + margin;
  input.m_maximumDistanceSquared = most * most;
  Sink sink;
  detector.getClosestPoints(input, sink, nullptr);
  if (sink.separation.gap > margin) sink.separation.found = false;
  if (axis && !sink.separation.found) {
    const btVector3 d = detector.getCachedSeparatingAxis();
    *axis = -Vec3(d.x(), d.y(), d.z()).normalized();
  }
  return sink.separation;
}

}  // namespace cogrsim::dynamics
