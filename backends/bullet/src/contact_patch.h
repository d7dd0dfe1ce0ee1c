// Contact points of one pair found afresh in one step, and their way into Bullet's manifold.
#pragma once

#include <array>

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

namespace cogrsim::bullet {

/// A point of shape A near shape B. The normal points from B to A.
struct PatchPoint {
  btVector3 on_a;
  btVector3 on_b;
  btVector3 normal;
  double distance = 0.0;  ///< negative: overlap [m]
  int feature = -1;       ///< the same as in the last step for the same corner; -1: unknown
};

/// Collects points and keeps the four that matter.
class ContactPatch {
 public:
  void clear() { count_ = 0; }
  int size() const { return count_; }
  const PatchPoint& point(int i) const { return points_[static_cast<std::size_t>(i)]; }
  void add(const PatchPoint& point);

  /// Replaces the manifold's points. What the old ones knew of the last step's impulses goes to
  /// the new ones: by feature, else to the nearest within `reach` [m].
  void commit(btPersistentManifold& manifold, const btTransform& X_WA, const btTransform& X_WB,
              double reach) const;

 private:
  static constexpr int kCapacity = 48;
  int reduce(std::array<int, 4>& chosen) const;

  std::array<PatchPoint, kCapacity> points_;
  int count_ = 0;
};

}  // namespace cogrsim::bullet
