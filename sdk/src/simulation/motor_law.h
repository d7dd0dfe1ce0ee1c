// Conversion of the target of a motor to the drive of one step.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// State of a motor.
struct MotorState {
  double target = 0.0;    ///< unit: see Motor
  double integral = 0.0;  ///< of the position error of a servo [rad s] or [m s]
};

/// The state at time 0: the target of the scene, or else 0, or the initial joint position in the
/// position and servo modes.
MotorState initial_motor_state(const SceneModel& model, const Motor& motor);

/// Clamps a target to the limits of the motor.
double clamp_target(const SceneModel& model, const Motor& motor, double target);

/// The smaller of the limits of the motor and its joint.
double motor_max_effort(const SceneModel& model, const Motor& motor);
double motor_max_speed(const SceneModel& model, const Motor& motor);

/// Indices of the driven coordinate and its speed in the flat arrays of a state.
int motor_position_index(const SceneModel& model, const Motor& motor);
int motor_speed_index(const SceneModel& model, const Motor& motor);

/// Computes the drives of all motors for a step of `dt` [s] from the state before the step, and
/// updates the integrals of the servos.
void make_drives(const SceneModel& model, const WorldState& state, double dt,
                 std::vector<MotorState>& motors, std::vector<Drive>& drives);

}  // namespace cogrsim
