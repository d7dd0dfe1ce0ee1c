// `cogrsim studio`: puts network, run and document together.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/model/scene_model.h"

namespace cogrsim::studio {

struct StudioOptions {
  std::string file;  ///< scene or recording; empty: chosen on the start page
  std::string host = "127.0.0.1";
  unsigned short port = 0;  ///< 0: 8642 or one of those behind it, else any that is free
  /// Whether the address is the same one after a restart within a day; empty: if only this machine's
  /// users reach the studio, and the page builds nothing.
  std::optional<bool> keep_token;
  bool open = true;     ///< a browser
  std::string backend;  ///< empty: the scene's
  double step = 0.0;    ///< [s]; 0: the scene's
  std::optional<std::uint64_t> seed;
  std::map<std::string, std::string> parameters;
  bool allow_build = false;
  std::vector<std::string> plugin_paths;
  Isolation isolation = Isolation::process;  ///< of controllers that do not say
  std::vector<std::string> without;          ///< see SimulationOptions
};

/// Serves until SIGINT or SIGTERM. Returns a cli::ExitStatus.
int studio_command(const StudioOptions& options);

}  // namespace cogrsim::studio
