// The options of the subcommands that read recordings: info and replay.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommands; `status` receives the exit status when one of them runs. Both must outlive
/// the parsing.
void add_info(CLI::App& app, int& status);
void add_replay(CLI::App& app, int& status);

struct InfoOptions {
  std::string file;
  std::string json;  ///< file, "-" or empty
  std::string extract;  ///< folder for the attached files; empty: they stay inside
};

struct ReplayOptions {
  std::string file;
  std::optional<double> at;         ///< one frame [s]; empty: all
  std::string json;                 ///< file, "-" or empty
  std::string csv;                  ///< folder or empty
  std::string ros2;                 ///< file or empty
  std::vector<std::string> render;  ///< cameras and views
  std::string output = "pictures";  ///< folder of pictures
  double every = 0.04;              ///< time between pictures of a view [s]
  bool recompute = false;           ///< compute readings instead of those on file
  bool verify = false;              ///< compares both
  std::vector<std::string> plugin_paths;
};

int info_command(const InfoOptions& options);
int replay_command(const ReplayOptions& options);

}  // namespace cogrsim::cli
