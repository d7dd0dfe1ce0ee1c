// Random perturbation of the initial state: for repetitions that differ, and to find out when chaos
// decides a run.
#pragma once

#include <cstdint>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/state.h"

namespace cogrsim::cli {

/// `state` with every mechanism displaced by at most `size`: one that nothing holds to the world by
/// a vector, uniform in the ball of radius `size` [m]; each coordinate of a hinge, slider, cylindrical,
/// universal, planar or screw joint outside of loops by a number uniform within ± `size` [m or rad].
/// The same seed displaces alike on every engine. Bodies that do not move, and mechanisms of loops
/// that are held by the world, stay. Returns how many displacements were made.
int shake(const SceneModel& model, double size, std::uint64_t seed, WorldState& state);

}  // namespace cogrsim::cli
