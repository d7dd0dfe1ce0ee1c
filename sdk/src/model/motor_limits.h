// What the model says of a motor and the joint that it drives.
#pragma once

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// The axis that the motor drives; nullptr for a joint of another kind.
const JointAxis* driven_axis(const SceneModel& model, const Motor& motor);

/// The smaller of the limits of the motor and its joint.
double motor_max_effort(const SceneModel& model, const Motor& motor);
double motor_max_speed(const SceneModel& model, const Motor& motor);

/// Clamps a target to the limits of the motor.
double clamp_target(const SceneModel& model, const Motor& motor, double target);

/// Indices of the driven coordinate and its speed in the flat arrays of a state.
int motor_position_index(const SceneModel& model, const Motor& motor);
int motor_speed_index(const SceneModel& model, const Motor& motor);

}  // namespace cogrsim
