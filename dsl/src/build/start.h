// The state a scene starts in: which joints close loops, where the bodies are once the joints have
// their initial coordinates, and how fast everything moves.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

/// Where a body's initial twist comes from.
enum class TwistSource : char { none, assembly, itself };

/// The initial state as written; the rest follows from it.
struct StartHints {
  std::vector<TwistSource> body_twist;  ///< (nbody)
  std::vector<char> joint_position;     ///< (njoint) 1: `position` was given
  std::vector<char> joint_velocity;     ///< (njoint) 1: `velocity` was given
};

/// A joint that the initial state of its bodies violates.
struct StartProblem {
  enum class Kind {
    gap,       ///< poses: `linear` [m] and `angular` [rad] are left between its two frames
    velocity,  ///< twists: `linear` [m/s] and `angular` [rad/s] are not free in this joint
    position   ///< the poses fit, but not at the coordinate that was given
  } kind = Kind::gap;
  int joint = -1;
  double linear = 0.0;
  double angular = 0.0;
};

/// Moves the bodies along the joint tree by the joints' initial positions (the written poses are
/// q = 0), then gives twists the same way, and coordinates and speeds to all joints without. The
/// root of a tree is a static or kinematic body, else its first body that is not a joint's child. A
/// body that has a twist of its own keeps it, when its joint allows it.
/// Needs mark_loops() first. Returns what does not fit.
std::vector<StartProblem> settle_start(SceneModel& model, const StartHints& hints);

}  // namespace cogrsim::dsl
