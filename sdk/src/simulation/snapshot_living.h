// What regions, doors and rules remember, in snapshots on file: by name instead of by index.
#pragma once

#include "simulation/living_memory.h"
#include "simulation/snapshot_data.h"

namespace cogrsim::snapshots {

Json living_json(const SceneModel& model, const LivingMemory& memory);

/// Into a memory that was made for `model`; what is not there any more is left out.
void living_from(const Json& json, const SceneModel& model, LivingMemory& memory);

}  // namespace cogrsim::snapshots
