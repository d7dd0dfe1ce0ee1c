// The address that --live is given.
#pragma once

#include <string>

#include "common/options.h"

namespace cogrsim::cli {

/// "", "8765", "192.0.2.1", "192.0.2.1:8765", "[::1]:8765". Throws UsageError.
LiveOptions live_from(const std::string& argument);

}  // namespace cogrsim::cli
