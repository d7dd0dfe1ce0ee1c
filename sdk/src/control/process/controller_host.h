// The program cogrsim_controller_host.
#pragma once

#include "cogrsim/core/export.h"

namespace cogrsim {

/// All that it does. `command`: the worker's own program with its arguments and a final nullptr; none:
/// the worker is a fork. Returns the exit code.
COGRSIM_API int run_controller_host(char** command);

}  // namespace cogrsim
