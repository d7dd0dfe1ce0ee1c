// What a run is made of: the files and libraries whose change makes it another run.
#pragma once

#include <string>
#include <vector>

#include "options.h"
#include "scene_loading.h"

namespace cogrsim::cli {

/// Absolute paths: of the scene, what it imports and refers to, files that its plugins are told to
/// read, the plugins it names, the snapshot to go on from; those looked for in vain too. Of a scene
/// with errors, also the folders of plugins that the user named.
std::vector<std::string> used_files(const LoadedScene& scene, const RunOptions& options);

/// Where the plugin `name` is, and where it would be found before that.
std::vector<std::string> plugin_files(const PluginLoader& loader, const std::string& name);

}  // namespace cogrsim::cli
