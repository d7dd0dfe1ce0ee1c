// The state of a whole world, in flat arrays. Indices are those of SceneModel; entries of removed
// elements stay, with their last values.
#pragma once

#include <vector>

#include "cogrsim/core/types.h"

namespace cogrsim {

struct WorldState {
  std::vector<Pose> poses;               ///< X_WB of every body (nbody)
  std::vector<Twist> twists;             ///< of every body frame's origin, world axes (nbody)
  std::vector<double> joint_positions;   ///< q of every joint (SceneModel::joint_positions)
  std::vector<double> joint_velocities;  ///< u of every joint (SceneModel::joint_speeds)
  /// Mean effort along every speed during the last step by motors, springs, damping, friction and
  /// limits of the joint: all that acts along the axis, nothing of the joint's reaction
  /// (SceneModel::joint_speeds). Zero before the first step.
  std::vector<double> joint_efforts;
  std::vector<double> motor_efforts;  ///< mean effort of every motor during the last step (nmotor)
};

/// One point at which two bodies touched during the last step.
struct Contact {
  int body_a = -1, body_b = -1;    ///< SceneModel::bodies, body_a < body_b
  int shape_a = -1, shape_b = -1;  ///< within their bodies
  Vec3 point = Vec3::Zero();       ///< world [m]; halfway between the two surfaces
  Vec3 normal = Vec3::UnitZ();     ///< unit, world, from a to b
  double depth = 0.0;              ///< penetration [m]; negative: still apart
  Vec3 force = Vec3::Zero();       ///< mean over the step, on b, world [N]; -force acts on a
};

}  // namespace cogrsim
