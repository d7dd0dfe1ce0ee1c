// Turns what a motor aims at into the drive of one step.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// What a motor remembers.
struct MotorState {
  double target = 0.0;
  double integral = 0.0;  ///< of a servo's position error [rad s] or [m s]
};

/// At time 0: the scene's target, else 0, or the joint's initial position for position and servo.
MotorState initial_motor_state(const SceneModel& model, const Motor& motor);

/// `target` within what the motor can be asked for.
double clamp_target(const SceneModel& model, const Motor& motor, double target);

/// The smaller of the motor's and its joint's bounds.
double motor_max_effort(const SceneModel& model, const Motor& motor);
double motor_max_speed(const SceneModel& model, const Motor& motor);

/// Where the driven coordinate and its speed stand in the flat arrays of a state.
int motor_position_index(const SceneModel& model, const Motor& motor);
int motor_speed_index(const SceneModel& model, const Motor& motor);

/// The drives of all motors for a step of `dt`; advances the servos' integrals. `state` is the one
/// before the step.
void make_drives(const SceneModel& model, const WorldState& state, double dt,
                 std::vector<MotorState>& motors, std::vector<Drive>& drives);

}  // namespace cogrsim
