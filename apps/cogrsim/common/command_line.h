// Parses the command line into the options of a subcommand, and runs it.
#pragma once

#include <memory>
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

/// The table of all commands and options. It is the parser; help, reference, manual page and
/// completion are made from it. A command that is parsed is run, and sets `status`, which outlives
/// the table.
std::shared_ptr<CLI::App> command_table(const std::vector<AddCommands>& more, int& status);

/// Returns the exit status: 0 good, 1 the scene or run failed, 2 wrong usage.
int run_command_line(int argc, char** argv, const std::vector<AddCommands>& more = {});

}  // namespace cogrsim::cli
