// The program cogrsim_controller_host.
#pragma once

#include "cogrsim/core/export.h"

namespace cogrsim {

/// All that it does. Returns the exit code.
COGRSIM_API int run_controller_host();

}  // namespace cogrsim
