// Which bodies hang together through joints.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

/// One articulated group: joints in an order in which neighbours follow each other (depth first
/// from the world, or from an end), loop-closing joints where they are met.
struct JointChain {
  std::vector<int> joints;
  int longest = 0;  ///< joints in a row, from the root to the farthest body
  bool loops = false;
};

/// Groups of joints that share dynamic bodies; free joints hold nothing and are left out.
std::vector<JointChain> find_joint_groups(const SceneModel& model);

}  // namespace cogrsim::bullet
