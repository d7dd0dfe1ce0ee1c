// cogrsim transfer: whether a policy stands on other engines.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_transfer(CLI::App& app, int& status);

}  // namespace cogrsim::cli
