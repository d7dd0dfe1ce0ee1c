// Plugins that are no libraries: classes of another language in this process.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// Finds a plugin by its whole name ("py:steer.Steer"). `folders` are those of the loader that asks.
/// The descriptor stays valid as long as the pointer exists. Errors: CG0901 not found, CG0903 wrong
/// kind. Must be thread-safe.
using PluginSource = std::function<Result<std::shared_ptr<const PluginDescriptor>>(
    PluginKind kind, const std::string& name, const std::vector<std::string>& folders)>;

/// The command, program first, that runs the controller with this name in a process of its own. The
/// program makes the same source known and calls serve_isolated_controller(). It inherits this
/// process's environment and folder. Errors: the controller is known to this process alone. Must be
/// thread-safe.
using PluginHost = std::function<Result<std::vector<std::string>>(const std::string& name)>;

/// Makes every PluginLoader of this process take the plugins whose names start with `prefix` ("py:")
/// from `source` instead of a folder. A loader requests each plugin once and keeps it; Plugin::path()
/// is empty. Without a `host`, its controllers cannot run in processes of their own. An empty source
/// removes the prefix. Thread-safe.
COGRSIM_API void set_plugin_source(const std::string& prefix, PluginSource source,
                                   PluginHost host = {});

/// Runs one controller for the simulation that has started this process, until that ends it. Returns
/// the exit code; 2: no simulation has started this process.
COGRSIM_API int serve_isolated_controller();

}  // namespace cogrsim
