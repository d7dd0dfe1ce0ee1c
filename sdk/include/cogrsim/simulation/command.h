// The only way to change a running world: commands, applied at a step boundary, in order.
#pragma once

#include <string>
#include <variant>

#include "cogrsim/physics/world.h"

namespace cogrsim {

/// Stops the flow of time; `Resume` and `StepOnce` go on.
struct Pause {};
struct Resume {};
/// One step while paused.
struct StepOnce {};
/// Simulated seconds per wall-clock second, > 0; infinity: as fast as possible. Never changes a
/// result.
struct SetSpeed {
  double factor = 1.0;
};
/// Another step length from now on [s]. Changes results, and is a different thing from speed.
struct SetStep {
  double dt = 1e-3;
};
/// Back to time 0, everything as at the start, controllers anew.
struct Restart {};
/// Adds the elements of `fragment` under the name `name`, its world frame placed at `pose`: a scene
/// model whose bodies, joints, motors and sensors form one assembly.
struct AddAssembly {
  SceneModelPtr fragment;
  std::string name;
  Pose pose;
};
struct RemoveAssembly {
  std::string name;
};
/// Target of a motor, as MotorHandle::set.
struct SetMotor {
  std::string motor;
  double target = 0.0;
};
struct EnableSensor {
  std::string sensor;
  bool on = true;
};
/// Constant twist of a kinematic body from now on.
struct SetKinematicTwist {
  std::string body;
  Twist twist;
};
/// Moves everything: see World::set_state.
struct SetState {
  WorldState state;
};
struct EndRun {
  std::string reason;
};

using Command =
    std::variant<Pause, Resume, StepOnce, SetSpeed, SetStep, Restart, AddAssembly, RemoveAssembly,
                 SetMotor, EnableSensor, SetKinematicTwist, SetState, EndRun>;

}  // namespace cogrsim
