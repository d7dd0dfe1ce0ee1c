// What of a plugin must not change while somebody relies on it.
#pragma once

#include <string>

#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// Parameters and outputs of a plugin, as text: equal for two builds of it that can stand in for
/// each other without anything else being told.
std::string shape_of(const PluginDescriptor& plugin);

}  // namespace cogrsim
