// What keeps bodies that overlap at the start from moving apart.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/geometry/overlap.h"

namespace cogrsim::dsl {

/// Joints that press two overlapping bodies against each other.
struct Pressing {
  std::vector<int> joints;  ///< SceneModel::joints, from the first body to the second
  bool limits = false;      ///< they could move apart, if these joints were not at their limits
};

class JointPaths {
 public:
  explicit JointPaths(const SceneModel& model);

  /// nullopt: no joint connects the two, or one lets them move apart along the overlap's normal.
  /// Bodies that nothing moves count as the world. Looked at is the shortest way from body to body;
  /// what a loop forbids in addition is not.
  std::optional<Pressing> pressing(const geometry::Overlap& overlap) const;

 private:
  std::size_t node(int body) const;
  std::vector<int> path(int from, int to) const;

  const SceneModel& model_;
  std::vector<std::vector<int>> joints_;  // by node
};

}  // namespace cogrsim::dsl
