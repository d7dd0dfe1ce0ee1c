// Joints that keep bodies that overlap at the start from separating.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/geometry/overlap.h"

namespace cogrsim::dsl {

/// Joints that press two overlapping bodies against each other.
struct Pressing {
  std::vector<int> joints;  ///< SceneModel::joints, from the first body to the second
  bool limits = false;      ///< they could separate, if these joints were not at their limits
};

class JointPaths {
 public:
  explicit JointPaths(const SceneModel& model);

  /// nullopt: no joint connects the two, or one lets them separate along the overlap's normal.
  /// Static bodies count as the world. Only the shortest path of joints between the bodies is
  /// checked, not the additional constraints of loops.
  std::optional<Pressing> pressing(const geometry::Overlap& overlap) const;

 private:
  std::size_t node(int body) const;
  std::vector<int> path(int from, int to) const;

  const SceneModel& model_;
  std::vector<std::vector<int>> joints_;  // by node
};

}  // namespace cogrsim::dsl
