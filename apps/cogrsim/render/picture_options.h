// The options of the subcommands that draw: map and render.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommands; `status` receives the exit status when one of them runs. Both must outlive
/// the parsing.
void add_map(CLI::App& app, int& status);
void add_render(CLI::App& app, int& status);

}  // namespace cogrsim::cli
