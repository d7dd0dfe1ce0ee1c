// The effect of an edit of the scene on a run that has begun.
#pragma once

#include "cogrsim/simulation/simulation.h"

namespace cogrsim::studio {

/// Moves the bodies and joints that an edit has moved. `simulation` continues with the scene
/// `after` from a state of a run of `before`; the rule is:
///
/// A body whose initial pose or twist the edit has changed, or a joint whose type, frames or initial
/// coordinates it has changed or that is new, takes its whole mechanism (all bodies that joints
/// connect to it, the world and fixed bodies being no connection) to the initial state of `after`.
/// All other mechanisms keep their state. So a mechanism is never torn apart, and never has half of
/// its state from one time and half from another.
///
/// Returns whether anything was moved. Errors: the engine refuses the state.
Result<bool> place_edited(Simulation& simulation, const SceneModel& before,
                          const SceneModel& after);

}  // namespace cogrsim::studio
