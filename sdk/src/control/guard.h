// The guard of a controller's process: see child_process.h.
#pragma once

#include "cogrsim/core/export.h"

namespace cogrsim::guard {

// Descriptors that the program finds open.
inline constexpr int kMemory = 3;
inline constexpr int kLink = 4;
inline constexpr int kFirstFree = 10;

/// All that the program cogrsim_controller_host does.
COGRSIM_API int run();

}  // namespace cogrsim::guard
