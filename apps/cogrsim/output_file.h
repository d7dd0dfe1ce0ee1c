// Writes results whole or not at all.
#pragma once

#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

/// Whether a file of this name could be written, asked before a long run starts. "-" is stdout.
/// Errors: its folder is missing or not writable, it is a folder, it may not be replaced.
Result<> check_writable(const std::string& path);

/// Writes `text` to a new file beside `path` and renames it; a device or pipe is written directly;
/// "-" is stdout. Errors: as check_writable, disk full; `path` is then as it was.
Result<> write_output(const std::string& path, const std::string& text);

/// Prints to stdout and makes sure it arrived.
Result<> print_output(const std::string& text);

}  // namespace cogrsim::cli
