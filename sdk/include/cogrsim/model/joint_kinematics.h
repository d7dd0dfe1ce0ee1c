// Kinematics of the joints: the definition of the joint coordinates that all engines share.
#pragma once

#include <algorithm>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// Whether speed `i` of a joint (0 to speed_count(type) - 1) is angular [rad/s] and not linear
/// [m/s]. The coordinate of the same index has the corresponding unit ([rad] or [m]), except for
/// ball and free joints, whose orientation is a quaternion.
COGRSIM_API bool axis_turns(JointType type, int i);

/// The axis of that speed where all coordinates are zero and F and M are one: a unit vector, for ball
/// joints and the six speeds of free ones, too.
COGRSIM_API Vec3 axis_direction(JointType type, int i);

/// What acts along speed `i` of a joint that has axes; the speeds of a ball share one entry.
inline const JointAxis& axis_of_speed(const Joint& joint, int i) {
  return joint.axes[std::min(static_cast<std::size_t>(i), joint.axes.size() - 1)];
}

/// Pose X_FM of the child's joint frame M in the parent's joint frame F for the coordinates `q`
/// (position_count(type) entries).
COGRSIM_API Pose joint_pose(const Joint& joint, const double* q);

/// Twist of M relative to F at the origin of M, expressed in F, for the speeds `u`
/// (speed_count(type) entries) at the coordinates `q`.
COGRSIM_API Twist joint_twist(const Joint& joint, const double* q, const double* u);

/// Rate of joint_twist() at constant speeds `u`: of its components in F. Zero but for universal joints
/// and gimbals, whose later axes turn in F.
COGRSIM_API Twist joint_twist_rate(const Joint& joint, const double* q, const double* u);

/// Computes the coordinates `q` (position_count(type) entries) of a relative pose X_FM. Motion that
/// the joint does not allow is ignored; joint_error() measures it. Angles are within pi of
/// `previous` (position_count(type) entries, which may be `q`), so that full turns are counted; if
/// `previous` is nullptr, they are in (-pi, pi].
COGRSIM_API void joint_position(const Joint& joint, const Pose& X_FM, const double* previous,
                                double* q);

/// Computes the speeds `u` (speed_count(type) entries) of a relative twist V_FM (at the origin of
/// M, expressed in F) at the coordinates `q`.
COGRSIM_API void joint_velocity(const Joint& joint, const Pose& X_FM, const Twist& V_FM,
                                const double* q, double* u);

/// Constraint violation of a joint: distance [m] and angle [rad] between the actual pose of M and
/// the pose that follows from the joint coordinates.
struct JointError {
  double distance = 0.0;
  double angle = 0.0;
};
COGRSIM_API JointError joint_error(const Joint& joint, const Pose& X_FM);

/// X_FM of a joint, from the poses of the parent and child bodies in the world (identity for the
/// world itself).
COGRSIM_API Pose relative_pose(const Joint& joint, const Pose& X_WP, const Pose& X_WC);

/// V_FM of a joint at the origin of M, expressed in F, from the poses and twists of the two bodies
/// in the world.
COGRSIM_API Twist relative_twist(const Joint& joint, const Pose& X_WP, const Twist& V_WP,
                                 const Pose& X_WC, const Twist& V_WC);

}  // namespace cogrsim
