// Other programs: started without a shell, and waited for.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <system_error>
#include <vector>

#include <tl/expected.hpp>

#include "cogrsim/core/export.h"

namespace cogrsim {

struct ProgramOptions {
  std::string folder;                 ///< in which it runs; empty: that of this process
  std::vector<std::string> unset;     ///< prefixes of environment variables that it does not get
  std::chrono::seconds longest{300};  ///< after this wall-clock time it is killed
  std::size_t most_output = 4000;     ///< of which at least the end is returned [byte]
  std::function<bool()> cancelled;    ///< asked ten times a second; true: it is killed
};

struct ProgramEnd {
  int status = 0;       ///< exit status; 128 if a signal ended it
  bool killed = false;  ///< it took too long, or was cancelled
  std::string output;   ///< of its standard output and standard error
};

/// Runs `command`, a program on the PATH and its arguments, until it ends. Its standard input is
/// empty. It and the processes that it starts are a process group, which is killed as one. Errors:
/// those of the system, for example that there is no such program.
COGRSIM_API tl::expected<ProgramEnd, std::error_code> run_program(
    std::vector<std::string> command, const ProgramOptions& options = {});

}  // namespace cogrsim
