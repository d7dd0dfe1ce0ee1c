// What of delays and latencies a run has memory for.
#pragma once

#include <optional>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

/// What is wrong with the latency of a sensor whose readings have so many values: CG0716.
std::optional<Error> unusable_latency(const SensorModel& sensor, double step, double values);

}  // namespace cogrsim
