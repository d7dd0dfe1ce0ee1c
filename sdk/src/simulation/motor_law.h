// Conversion of the target of a motor to the drive of one step.
#pragma once

#include <deque>
#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// A target that has not acted yet.
struct DelayedTarget {
  double time = 0.0;  ///< of the step in which it was set [s]
  double target = 0.0;
};

/// State of a motor.
struct MotorState {
  double target = 0.0;    ///< unit: see Motor
  double acting = 0.0;    ///< the target of the step, as old as the motor's delay
  double integral = 0.0;  ///< of the position error of a servo [rad s] or [m s]
  bool follows = true;    ///< its signal, if it has one: nothing else has set its target
  std::deque<DelayedTarget> waiting;  ///< by time; empty without a delay
};

/// The state at time 0: the target of the scene, or else 0, or the initial joint position in the
/// position and servo modes.
MotorState initial_motor_state(const SceneModel& model, const Motor& motor);

/// Determines the targets that act in the step of `dt` [s] that begins at `time` [s].
void take_targets(const SceneModel& model, double time, double dt, std::vector<MotorState>& motors);

/// Computes the drives of all motors for a step of `dt` [s] from the state before the step, and
/// updates the integrals of the servos.
void make_drives(const SceneModel& model, const WorldState& state, double dt,
                 std::vector<MotorState>& motors, std::vector<Drive>& drives);

}  // namespace cogrsim
