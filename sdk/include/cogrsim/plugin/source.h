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

/// Makes every PluginLoader of this process take the plugins whose names start with `prefix` ("py:")
/// from `source` instead of a folder. A loader requests each plugin once and keeps it; Plugin::path()
/// is empty. Controllers of a source cannot run in a process of their own. An empty source removes
/// the prefix. Thread-safe.
COGRSIM_API void set_plugin_source(const std::string& prefix, PluginSource source);

}  // namespace cogrsim
