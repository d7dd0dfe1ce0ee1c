// The state of a whole world in flat arrays. The indices are those of SceneModel; the entries of
// removed elements remain with their last values.
#pragma once

#include <vector>

#include "cogrsim/core/types.h"

namespace cogrsim {

/// State of all bodies, joints and motors at one time.
struct WorldState {
  std::vector<Pose> poses;               ///< X_WB of every body (nbody)
  std::vector<Twist> twists;             ///< of every body origin, in world axes (nbody)
  std::vector<double> joint_positions;   ///< q of all joints (SceneModel::joint_positions)
  std::vector<double> joint_velocities;  ///< u of all joints (SceneModel::joint_speeds)
  /// Mean effort along every joint speed during the last step [N m] or [N]: the sum of motors,
  /// springs, damping, friction and limits of the joint, without the constraint reaction
  /// (SceneModel::joint_speeds). Zero before the first step.
  std::vector<double> joint_efforts;
  /// Mean effort of every motor during the last step [N m] or [N] (nmotor).
  std::vector<double> motor_efforts;
};

/// A contact point of two bodies during the last step. Vectors are in the world frame.
struct Contact {
  int body_a = -1, body_b = -1;    ///< indices into SceneModel::bodies, body_a < body_b
  int shape_a = -1, shape_b = -1;  ///< indices into the shapes of the two bodies
  Vec3 point = Vec3::Zero();       ///< halfway between the two surfaces [m]
  Vec3 normal = Vec3::UnitZ();     ///< unit vector from a to b
  double depth = 0.0;              ///< penetration [m]; negative: distance between the surfaces
  Vec3 force = Vec3::Zero();       ///< mean force on b over the step [N]; -force acts on a
};

}  // namespace cogrsim
