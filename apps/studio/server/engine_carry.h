// What an edit of the scene means for a run that has begun.
#pragma once

#include "cogrsim/simulation/simulation.h"

namespace cogrsim::studio {

/// Puts what was moved by an edit where the edit puts it. `simulation` goes on with the scene
/// `after` from a state that came about with `before`; the rule is:
///
/// A body whose initial pose or twist the edit has changed, or a joint whose type, frames or initial
/// coordinates it has changed or that is new, takes its whole mechanism (all bodies that joints
/// connect to it, the world and fixed bodies being no connection) to the initial state of `after`.
/// All other mechanisms go on as they are. So a mechanism is never torn apart, and never half of one
/// time, half of another.
///
/// Returns whether anything was moved. Errors: the engine refuses the state.
Result<bool> place_edited(Simulation& simulation, const SceneModel& before,
                          const SceneModel& after);

}  // namespace cogrsim::studio
