// Definitions of the ROS 2 messages that recordings are written as.
#pragma once

#include <string>

namespace cogrsim::ros2 {

/// The definition of a message with those of all that it contains, as MCAP's encoding `ros2msg` has
/// it. `type`: "sensor_msgs/msg/Imu"; one that ros2_types.cpp lists.
std::string schema_of(const std::string& type);

}  // namespace cogrsim::ros2
