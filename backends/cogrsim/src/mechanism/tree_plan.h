// Which joint carries which body: a spanning forest over the bodies that move, and the joints where
// loops are cut.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::dynamics {

/// One mobilized body to be. A parent comes before its children.
struct PlannedLink {
  int body = -1;    ///< SceneModel::bodies
  int joint = -1;   ///< the joint that carries it; -1: it is the base of a tree and moves freely
  int parent = -1;  ///< link; -1: something that never moves (see `anchor`)
  int anchor = kWorld;    ///< with a joint and no parent link: the fixed body, or the world
  bool reversed = false;  ///< the inboard body is the joint's child
  /// Where a loop is cut, one of the two bodies is split: this link stands for it at the joint, has
  /// its share of mass and inertia, and is welded to the body's own link.
  bool shadow = false;
  double share = 1.0;  ///< of the body's mass and inertia
  int component = -1;  ///< of those that forces move, see components.h; -1: kinematic
};

struct TreePlan {
  /// Kinematic ones, then component by component, tree by tree, a parent before its children.
  std::vector<PlannedLink> links;
  std::vector<int> body_link;   ///< (nbody); -1: fixed or removed
  std::vector<int> joint_link;  ///< link that the joint carries (njoint); -1: moves nothing
};

/// Bodies are reached breadth first: from all that never moves, then from each kinematic body, then
/// from the first dynamic body, in model order, that nothing has reached. Deterministic, and
/// independent of anything later in the model that is not connected.
TreePlan plan_tree(const SceneModel& model);

}  // namespace cogrsim::dynamics
