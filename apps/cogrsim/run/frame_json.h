// A frame as JSON: bodies, joints and contacts as in the result of a run, and its readings.
#pragma once

#include <functional>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/sensing/sensor.h"
#include "common/json_text.h"

namespace cogrsim::cli {

/// The channels of a sensor's values, by sensor index.
using ChannelsOf = std::function<const std::vector<Channel>&(int)>;

Json bodies_json(const Frame& frame);
Json joints_json(const Frame& frame);
Json contacts_json(const Frame& frame);
/// time, kind, source, subject, message.
Json to_json(const Event& event);
/// By sensor: time, sequence, valid, enabled, values by channel.
Json readings_json(const Frame& frame, const ChannelsOf& channels);
/// All of it, with step, time and events.
Json frame_json(const Frame& frame, const ChannelsOf& channels);

}  // namespace cogrsim::cli
