// cogrsim run --watch: a run that is restarted whenever a file changes that it depends on.
#pragma once

#include "common/options.h"

namespace cogrsim::cli {

/// Runs the scene in a child process, again and again, until Ctrl-C; a scene with errors, or a
/// plugin that crashes, is reported, and the next change is waited for. Returns the exit status of
/// the latest run.
int watch_command(const RunOptions& options);

}  // namespace cogrsim::cli
