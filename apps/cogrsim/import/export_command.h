// cogrsim export: a scene or an assembly as URDF, SDF or MJCF, with a report of what was lost.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_export(CLI::App& app, int& status);

}  // namespace cogrsim::cli
