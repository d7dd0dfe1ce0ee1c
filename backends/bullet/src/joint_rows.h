// What a joint forbids and what it leaves free, as rows on the two bodies' relative velocity.
#pragma once

#include <array>

#include <LinearMath/btTransform.h>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

/// One direction of relative motion: velocity = lin . (v_C - v_P) + ang . (w_C - w_P), with v_C and
/// v_P the velocities of both bodies' points at M's origin; world axes. The pair (lin, ang) is also
/// the force and torque on the child, about M's origin, that belongs to it.
struct Direction {
  btVector3 lin{0, 0, 0};
  btVector3 ang{0, 0, 0};
};

/// Number of directions that the joint forbids: 6 minus its freedom.
int locked_count(JointType type);

/// The forbidden directions at the frames' present places; returns their number.
/// With rates of the errors below these agree to first order in the errors.
int locked_directions(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                      std::array<Direction, 6>& out);

/// How far the forbidden coordinates are from zero, in the same order [m] or [rad]. `q` are the
/// joint's coordinates there (a screw needs its angle with turns counted).
void locked_errors(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                   const double* q, std::array<double, 6>& out);

/// The free directions, one per speed; not for ball and free joints.
int free_directions(const Joint& joint, const btTransform& X_WF, const btTransform& X_WM,
                    std::array<Direction, 3>& out);

/// Rotation vector of a unit quaternion, shorter way round [rad].
btVector3 rotation_vector(const btQuaternion& q);

}  // namespace cogrsim::bullet
