// A run without an engine, for targets that need one.
#pragma once

#include <memory>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim::fuzz {

/// The text of a small scene with bodies, sensors, a region, a rule and a figure, for backend `toy`.
extern const char* const kToyScene;
SceneModelPtr toy_scene();
/// Finds the backend `toy`.
std::shared_ptr<PluginLoader> toy_loader();

}  // namespace cogrsim::fuzz
