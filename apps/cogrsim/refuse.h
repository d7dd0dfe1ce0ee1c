// How a subcommand ends that cannot do what it was asked.
#pragma once

#include "cogrsim/core/result.h"
#include "options.h"
#include "terminal.h"

namespace cogrsim::cli {

/// Prints the error to stderr and gives the exit status back.
inline int refuse(const Error& error, int status = kFailed) {
  print_error(error.text());
  return status;
}

}  // namespace cogrsim::cli
