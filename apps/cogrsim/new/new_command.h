// cogrsim new: makes a project that builds, has a test and a scene, and says what to do next.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_new(CLI::App& app, int& status);

struct NewOptions {
  std::string kind;                       ///< "backend", "controller", "sensor", "supervisor"
  std::string name;                       ///< of the plugin and of its folder
  std::string language;                   ///< of a backend: "c++", "js" or "python"; empty: C++
  std::string into = ".";                 ///< folder in which that folder is made
  std::vector<std::string> plugin_paths;  ///< where a plugin of this name might be already
};

/// Makes the project, whole or not at all, and says how to build it. Never replaces anything.
int new_command(const NewOptions& options);

/// The kinds of projects, one line each.
std::string new_kinds_text();

}  // namespace cogrsim::cli
