// The memory that frames take, for caches of frames.
#pragma once

#include <cstddef>

#include "cogrsim/physics/frame.h"

namespace cogrsim {

/// Memory of a frame [byte], without its images, which several frames share.
inline std::size_t bytes_of(const Frame& frame) {
  const auto of = [](const auto& elements) {
    return elements.capacity() * sizeof(elements.front());
  };
  const WorldState& state = frame.state;
  std::size_t bytes = sizeof(Frame) + of(state.poses) + of(state.twists) +
                      of(state.joint_positions) + of(state.joint_velocities) +
                      of(state.joint_efforts) + of(state.motor_efforts) + of(frame.motor_targets) +
                      of(frame.accelerations) + of(frame.contacts) + of(frame.joint_reactions) +
                      of(frame.readings) + of(frame.events) + of(frame.controller_outputs) +
                      of(frame.supervisor_outputs);
  for (const Reading& reading : frame.readings) bytes += of(reading.values) + of(reading.contacts);
  for (const auto* outputs : {&frame.controller_outputs, &frame.supervisor_outputs})
    for (const std::vector<double>& values : *outputs) bytes += of(values);
  return bytes;
}

}  // namespace cogrsim
