// Between a run and the process that restarts it when a file changes.
#pragma once

#include <string>
#include <vector>

#include "common/options.h"

namespace cogrsim::cli {

class WatchLink {
 public:
  virtual ~WatchLink() = default;

  /// Absolute paths of files and libraries that the run uses, or that it looked for; of a folder,
  /// the libraries in it. To be called as soon as they are known; may be called again. `instead`:
  /// these replace all paths from before, those of earlier runs too.
  virtual void depends_on(const std::vector<std::string>& paths, bool instead) = 0;

  /// A file has changed: the run ends, and its result is not needed.
  virtual bool superseded() const = 0;
};

/// run_command() under `--watch`; nullptr: without it.
int run_command(const RunOptions& options, WatchLink* watch);

}  // namespace cogrsim::cli
