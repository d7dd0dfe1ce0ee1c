// cogrsim bundle: a run in one page that opens from disk.
#pragma once

#include <string>

#include "common/options.h"

namespace cogrsim::studio {

struct BundleOptions {
  cli::FrameSourceOptions source;  ///< a scene or a recording
  std::string output;              ///< empty: the scene's name with .html, here
  double every = 1.0 / 60.0;       ///< between frames [s]; 0: every step
  int size = 64;                   ///< of frames and curves before they are compressed [MB]
  bool force = false;              ///< replaces whatever is there
};

/// Returns the exit status. A run that fails is bundled as far as it came.
int bundle_command(const BundleOptions& options);

}  // namespace cogrsim::studio
