// The options of cogrsim bundle.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::studio {

/// Adds the subcommand; its callback sets `status`.
void add_bundle(CLI::App& app, int& status);

}  // namespace cogrsim::studio
