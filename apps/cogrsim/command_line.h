// Turns the words of the command line into the options of a subcommand, and runs it.
#pragma once

#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds subcommands; their callbacks set `status`.
using AddWords = void (*)(CLI::App& app, int& status);

/// What this program has beside the subcommands of its own: the studio and what belongs to it. Each
/// program links one definition.
std::vector<AddWords> more_words();

/// Returns the exit status: 0 good, 1 the scene or run failed, 2 wrong usage.
int run_command_line(int argc, char** argv, const std::vector<AddWords>& more = {});

}  // namespace cogrsim::cli
