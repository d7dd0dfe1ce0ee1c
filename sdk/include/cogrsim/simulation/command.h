// The only way to change a running world: commands, applied at a step boundary, in order. Those that
// scenes can name too are in cogrsim/model/action.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "cogrsim/model/action.h"
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
struct Restart {
  std::optional<std::uint64_t> seed = {};  ///< of the run from now on; empty: the same again
};
/// Adds the elements of `fragment` under the name `name`, its world frame placed at `pose`: a scene
/// model whose bodies, joints, motors and sensors form one assembly.
struct AddAssembly {
  SceneModelPtr fragment;
  std::string name;
  Pose pose;
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
namespace detail {
template <class... Own, class... Shared>
std::variant<Own..., Shared...> joined_variant(std::variant<Shared...>*);
}  // namespace detail

/// The commands above, and everything an Action can be.
using Command = decltype(detail::joined_variant<Pause, Resume, StepOnce, SetSpeed, SetStep, Restart,
                                                AddAssembly, SetKinematicTwist, SetState>(
    static_cast<Action*>(nullptr)));

}  // namespace cogrsim
