// cogrsim run --watch: a run that is started anew whenever something changes that it rests on.
#pragma once

#include "options.h"

namespace cogrsim::cli {

/// Runs the scene in a child process, again and again, until Ctrl-C; a scene with errors, or a
/// plugin that crashes, is told and waited on. Returns the exit status of the latest run.
int watch_command(const RunOptions& options);

}  // namespace cogrsim::cli
