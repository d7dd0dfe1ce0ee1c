// cogrsim policy import: cards from what other tools write.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/policy/card.h"

namespace cogrsim::cli {

struct PolicyImportOptions {
  std::vector<std::string> sources;  ///< files
  std::string output;                ///< card to write
  CardChanges answers;               ///< to what the sources leave open
};

/// Writes the card. Exit status.
int import_policy(const PolicyImportOptions& options, const std::vector<std::string>& plugin_paths);

}  // namespace cogrsim::cli
