// cogrsim import: a robot or world of another format as a scene, with a report of what was lost.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_import(CLI::App& app, int& status);

}  // namespace cogrsim::cli
