// Parses the command line into the options of a subcommand, and runs it.
#pragma once

#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds subcommands; their callbacks set `status`.
using AddCommands = void (*)(CLI::App& app, int& status);

/// The subcommands of the studio and of sharing, which this program may have. Each
/// program links one definition.
std::vector<AddCommands> extra_commands();

/// Returns the exit status: 0 good, 1 the scene or run failed, 2 wrong usage.
int run_command_line(int argc, char** argv, const std::vector<AddCommands>& more = {});

}  // namespace cogrsim::cli
