#include "contact_patch.h"

#include <algorithm>

#include <LinearMath/btTransform.h>

namespace cogrsim::bullet {

namespace {

// What differs by less is the same: rounding must not decide which points are kept, or they change
// from step to step and begin without the loads of the last.
constexpr double kSameDepth = 2e-5;  // [m], about what resting bodies sink in
constexpr double kClearly = 1.0 + 1e-6;

}  // namespace

void ContactPatch::add(const PatchPoint& point) {
  if (count_ < kCapacity) {
    points_[static_cast<std::size_t>(count_++)] = point;
    return;
  }
  // Full: the shallowest goes.
  auto* worst = std::max_element(points_.begin(), points_.end(), [](const auto& a, const auto& b) {
    return a.distance < b.distance;
  });
  if (point.distance < worst->distance) *worst = point;
}

int ContactPatch::reduce(std::array<int, 4>& chosen) const {
  const auto at = [&](int i) -> const PatchPoint& { return points_[static_cast<std::size_t>(i)]; };
  if (count_ <= 4) {
    for (int i = 0; i < count_; ++i) chosen[static_cast<std::size_t>(i)] = i;
    return count_;
  }
  // The deepest; the farthest from it; the farthest from their line, to either side.
  int a = 0;
  for (int i = 1; i < count_; ++i) {
    if (at(i).distance < at(a).distance - kSameDepth) a = i;
  }
  int b = a;
  for (int i = 0; i < count_; ++i) {
    if ((at(i).on_a - at(a).on_a).length2() > kClearly * (at(b).on_a - at(a).on_a).length2()) b = i;
  }
  const btVector3 line = at(b).on_a - at(a).on_a;
  const btVector3 side = at(a).normal.cross(line);
  int c = -1, d = -1;
  double most = 0.0, least = 0.0;
  for (int i = 0; i < count_; ++i) {
    const double s = side.dot(at(i).on_a - at(a).on_a);
    if (s > kClearly * most) {
      most = s;
      c = i;
    }
    if (s < kClearly * least) {
      least = s;
      d = i;
    }
  }
  int n = 0;
  for (const int i : {a, b, c, d}) {
    if (i < 0 || std::find(chosen.begin(), chosen.begin() + n, i) != chosen.begin() + n) continue;
    chosen[static_cast<std::size_t>(n++)] = i;
  }
  return n;
}

void ContactPatch::commit(btPersistentManifold& manifold, const btTransform& X_WA,
                          const btTransform& X_WB, double reach) const {
  std::array<btManifoldPoint, 4> old;
  const int old_count = manifold.getNumContacts();
  for (int i = 0; i < old_count; ++i) {
    old[static_cast<std::size_t>(i)] = manifold.getContactPoint(i);
  }
  std::array<int, 4> chosen{};
  const int n = reduce(chosen);
  manifold.setNumContacts(n);
  for (int k = 0; k < n; ++k) {
    const PatchPoint& p = points_[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])];
    btManifoldPoint& cp = manifold.getContactPoint(k);
    cp = btManifoldPoint(X_WA.invXform(p.on_a), X_WB.invXform(p.on_b), p.normal, p.distance);
    cp.m_positionWorldOnA = p.on_a;
    cp.m_positionWorldOnB = p.on_b;
    cp.m_index0 = p.feature;
    const btManifoldPoint* match = nullptr;
    double nearest = reach * reach;
    for (int i = 0; i < old_count; ++i) {
      const btManifoldPoint& o = old[static_cast<std::size_t>(i)];
      if (p.feature >= 0 && o.m_index0 == p.feature) {
        match = &o;
        break;
      }
      const double d2 = (o.m_localPointA - cp.m_localPointA).length2();
      if (p.feature < 0 && d2 < nearest) {
        nearest = d2;
        match = &o;
      }
    }
    if (match == nullptr) continue;
    cp.m_appliedImpulse = match->m_appliedImpulse;
    cp.m_prevRHS = match->m_prevRHS;
    cp.m_appliedImpulseLateral1 = match->m_appliedImpulseLateral1;
    cp.m_appliedImpulseLateral2 = match->m_appliedImpulseLateral2;
    cp.m_lateralFrictionDir1 = match->m_lateralFrictionDir1;
    cp.m_lateralFrictionDir2 = match->m_lateralFrictionDir2;
    cp.m_lifeTime = match->m_lifeTime + 1;
  }
}

}  // namespace cogrsim::bullet
