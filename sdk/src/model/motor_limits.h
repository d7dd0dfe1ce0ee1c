// What the model says of a motor and the joint that it drives.
#pragma once

#include <limits>

#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// The axis that the motor drives; nullptr for a joint of another kind.
const JointAxis* driven_axis(const SceneModel& model, const Motor& motor);

/// The smaller of the limits of the motor and its joint.
double motor_max_effort(const SceneModel& model, const Motor& motor);
double motor_max_speed(const SceneModel& model, const Motor& motor);

/// Whether the effort of the motor falls with its speed.
inline bool has_curve(const Motor& motor) {
  return motor.no_load_speed < std::numeric_limits<double>::infinity();
}

/// The efforts that a motor has at a speed.
struct EffortLimits {
  double forward = 0.0, backward = 0.0;  ///< largest towards larger and smaller coordinates, >= 0
};
/// On a speed-torque curve, with the largest effort `most`:
///
///     forward = clamp(stall_effort (1 - speed / no_load_speed), 0, most),
///
/// and backward the same of -speed. Braking is not limited by the curve below stall_effort. Source:
/// DCMotor._clip_effort of Isaac Lab (source/isaaclab/isaaclab/actuators/actuator_pd.py), where these
/// are saturation_effort, velocity_limit and effort_limit.
EffortLimits limits_on_curve(double stall_effort, double no_load_speed, double most, double speed);

/// Of a motor with or without a curve, within motor_max_effort().
EffortLimits effort_limits(const SceneModel& model, const Motor& motor, double speed);

/// Clamps a target to the limits of the motor.
double clamp_target(const SceneModel& model, const Motor& motor, double target);

/// Indices of the driven coordinate and its speed in the flat arrays of a state.
int motor_position_index(const SceneModel& model, const Motor& motor);
int motor_speed_index(const SceneModel& model, const Motor& motor);

}  // namespace cogrsim
