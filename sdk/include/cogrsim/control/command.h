// Commands change a running world. They are applied in order at the next step boundary. Commands
// that scenes can also use are in cogrsim/model/action.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "cogrsim/model/action.h"
#include "cogrsim/physics/world.h"

namespace cogrsim {

/// Pauses the simulation until `Resume` or `StepOnce`.
struct Pause {};
/// Resumes a paused simulation.
struct Resume {};
/// Makes one step of a paused simulation.
struct StepOnce {};
/// Sets the speed relative to real time. It does not affect the results.
struct SetSpeed {
  double factor = 1.0;  ///< simulated seconds per wall-clock second, > 0; infinity: no limit
};
/// Sets the time step. In contrast to the speed it affects the results.
struct SetStep {
  double dt = 1e-3;  ///< [s], > 0
};
/// Restarts the run at time 0 from the initial state, with new controllers.
struct Restart {
  std::optional<std::uint64_t> seed = {};  ///< seed of the new run; empty: the same seed
};
/// Adds the elements of a scene model as one assembly.
struct AddAssembly {
  SceneModelPtr fragment;  ///< bodies, joints, motors and sensors of the assembly
  std::string name;        ///< dotted name of the assembly; must not exist yet
  Pose pose;               ///< pose of the world frame of `fragment` in the world
};
/// Sets the constant twist of a kinematic body.
struct SetKinematicTwist {
  std::string body;  ///< dotted name
  Twist twist;       ///< of the body origin, in world axes
};
/// Applies a force and a torque to a dynamic body, beside those of the scene, for some time.
struct ApplyForce {
  std::string body;            ///< dotted name
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< [N m]
  Vec3 point = Vec3::Zero();   ///< at which the force acts, in the frame of the body [m]
  bool in_body = false;        ///< the vectors turn with the body; else they are in world axes
  double duration = 0.0;       ///< [s]; 0: one step
};
/// Sets an input of a controller, see Assembly::input(). A value outside of its limits is rejected.
struct SetInput {
  std::string controller;  ///< dotted name, or that of its assembly
  std::string input;
  double value = 0.0;  ///< in the unit of the input
};
/// Sets the state of the whole world, see World::set_state().
struct SetState {
  WorldState state;
};
namespace detail {
template <class... Own, class... Shared>
std::variant<Own..., Shared...> joined_variant(std::variant<Shared...>*);
}  // namespace detail

/// Any of the commands above or any Action.
using Command =
    decltype(detail::joined_variant<Pause, Resume, StepOnce, SetSpeed, SetStep, Restart,
                                    AddAssembly, SetKinematicTwist, ApplyForce, SetInput, SetState>(
        static_cast<Action*>(nullptr)));

}  // namespace cogrsim
