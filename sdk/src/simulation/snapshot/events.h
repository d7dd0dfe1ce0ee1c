// The state of regions, doors and rules in snapshot files, by name instead of by index.
#pragma once

#include "simulation/events/event_state.h"
#include "simulation/snapshot/data.h"

namespace cogrsim::snapshots {

Json event_state_json(const SceneModel& model, const EventState& memory);

/// Reads the state into `memory`, which was created for `model`; missing elements are skipped.
void event_state_from(const Json& json, const SceneModel& model, EventState& memory);

}  // namespace cogrsim::snapshots
