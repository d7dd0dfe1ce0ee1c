// Programs that run controllers of a source in processes of their own.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim {

/// The command for the controller with this name, see PluginHost. Errors: the host's own, or its
/// source has no host.
Result<std::vector<std::string>> host_command(const std::string& name);

}  // namespace cogrsim
