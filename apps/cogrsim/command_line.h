// Turns the words of the command line into the options of a subcommand, and runs it.
#pragma once

namespace cogrsim::cli {

/// Returns the exit status: 0 good, 1 the scene or run failed, 2 wrong usage.
int run_command_line(int argc, char** argv);

}  // namespace cogrsim::cli
