// The interface of a plugin that must not change while a run uses it.
#pragma once

#include <string>

#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// The parameters and outputs of a plugin as text. Two builds of a plugin can replace each other if
/// their texts are equal.
std::string shape_of(const PluginDescriptor& plugin);

}  // namespace cogrsim
