// The files and libraries that a run uses: a change of one makes it another run.
#pragma once

#include <string>
#include <vector>

#include "common/options.h"
#include "common/scene_loading.h"

namespace cogrsim::cli {

/// Absolute paths: of the scene, what it imports and refers to, files that its plugins read,
/// the plugins it names, the snapshot to resume from; those looked for in vain too. Of a scene
/// with errors, also the folders of plugins that the user named.
std::vector<std::string> used_files(const LoadedScene& scene, const RunOptions& options);

/// The path of the plugin `name`, and the paths that are searched before it.
std::vector<std::string> plugin_files(const PluginLoader& loader, const std::string& name);

}  // namespace cogrsim::cli
