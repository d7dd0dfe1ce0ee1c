// Names of plugins that are about to be made.
#pragma once

#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim::cli {

/// Longest name: it becomes part of file names and of one line in tables.
inline constexpr std::size_t kLongestPluginName = 60;

/// Whether a plugin can be called so: [a-z][a-z0-9_]*, not too long, no keyword of C++, no target
/// that CMake makes itself; a sensor not as one of the SDK's own, a backend not as an element of
/// scenes. Errors suggest a name that could be taken.
Result<> check_plugin_name(PluginKind kind, const std::string& name);

/// "wall_follower" -> "WallFollower". Precondition: check_plugin_name().
std::string class_name(const std::string& plugin);

/// A valid name similar to `text`: "MyRobot-2" -> "my_robot_2"; "" if there is none.
std::string suggested_name(const std::string& text);

}  // namespace cogrsim::cli
