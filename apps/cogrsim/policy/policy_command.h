// cogrsim policy: checks cards of trained policies, and lets them drive their robots.
#pragma once

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_policy(CLI::App& app, int& status);

}  // namespace cogrsim::cli
