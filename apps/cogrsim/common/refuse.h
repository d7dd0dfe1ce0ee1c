// The end of a subcommand that fails.
#pragma once

#include "cogrsim/core/result.h"
#include "common/options.h"
#include "common/terminal.h"

namespace cogrsim::cli {

/// Prints the error to stderr and gives the exit status back.
inline int refuse(const Error& error, int status = kFailed) {
  print_error(error.text());
  return status;
}

}  // namespace cogrsim::cli
