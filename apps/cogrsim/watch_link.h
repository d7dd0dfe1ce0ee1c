// Between a run and those who start it anew when something changes.
#pragma once

#include <string>
#include <vector>

#include "options.h"

namespace cogrsim::cli {

class WatchLink {
 public:
  virtual ~WatchLink() = default;

  /// Absolute paths of files and libraries that the run is made of, or that it looked for; of a
  /// folder, the libraries in it. To be told as soon as they are known; may be called again.
  /// `instead`: of these and no others that were told of before, by earlier runs either.
  virtual void rests_on(const std::vector<std::string>& paths, bool instead) = 0;

  /// Something has changed: the run ends, and nobody waits for its result.
  virtual bool superseded() const = 0;
};

/// run_command() for those who watch; nullptr: nobody does.
int run_command(const RunOptions& options, WatchLink* watcher);

}  // namespace cogrsim::cli
