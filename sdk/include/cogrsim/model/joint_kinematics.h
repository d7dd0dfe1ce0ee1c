// What joint coordinates mean, in one place for all engines.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Whether speed `i` of a joint (0 to speed_count(type) - 1) is an angular one [rad/s], not a linear
/// one [m/s]. So is the coordinate of the same number [rad], [m], but for ball and free joints, whose
/// orientation is a quaternion.
COGRSIM_API bool axis_turns(JointType type, int i);

/// Pose X_FM of the child's joint frame in the parent's for the coordinates `q`
/// (position_count(type) long).
COGRSIM_API Pose joint_pose(const Joint& joint, const double* q);

/// Relative twist of M in F, expressed in F, at M's origin, for speeds `u` at coordinates `q`.
COGRSIM_API Twist joint_twist(const Joint& joint, const double* q, const double* u);

/// Coordinates of the relative pose X_FM nearest to what the joint allows; the freedom it does not
/// have is ignored (see joint_error). Angles come out within pi of `previous` (position_count
/// long), so that turns are counted; nullptr: within (-pi, pi].
COGRSIM_API void joint_position(const Joint& joint, const Pose& X_FM, const double* previous,
                                double* q);

/// Speeds `u` of the relative twist V_FM (in F's axes, at M's origin) at coordinates `q`.
COGRSIM_API void joint_velocity(const Joint& joint, const Pose& X_FM, const Twist& V_FM,
                                const double* q, double* u);

/// How far the two bodies have left the joint: distance [m] and angle [rad] between where M is and
/// where the joint's own coordinates would put it.
struct JointError {
  double distance = 0.0;
  double angle = 0.0;
};
COGRSIM_API JointError joint_error(const Joint& joint, const Pose& X_FM);

/// X_FM of a joint from the poses of the two bodies in the world (identity for the world itself).
COGRSIM_API Pose relative_pose(const Joint& joint, const Pose& X_WP, const Pose& X_WC);

/// V_FM in F's axes at M's origin, from the bodies' poses and twists in the world.
COGRSIM_API Twist relative_twist(const Joint& joint, const Pose& X_WP, const Twist& V_WP,
                                 const Pose& X_WC, const Twist& V_WC);

}  // namespace cogrsim
