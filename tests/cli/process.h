// Runs the program as a user's shell would.
#pragma once

#include <sys/types.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "../support/temporary_folder.h"

/// The end of a program and its output.
struct Outcome {
  int status = -1;  ///< exit status; 128 + n: killed by signal n
  int signal = 0;   ///< by which it was killed; 0: by none
  std::string out, err;
};

/// Runs `cogrsim ARGS`, both streams piped. `interrupt_after` [s]: sends Ctrl-C then; 0: never.
Outcome cogrsim_run(const std::vector<std::string>& args, double interrupt_after = 0.0);

/// The same as a user with limited permissions: "nobody" where the test runs as root. Status 127:
/// that user cannot reach the program.
Outcome cogrsim_run_unprivileged(const std::vector<std::string>& args);

/// A running program, with checks that it is at work.
struct RunningProgram {
  pid_t pid = -1;
  bool printed() const;  ///< something is to be read from its standard output
  bool has_open(const std::string& path) const;
  bool waits_in_a_write() const;  ///< as when its output is not read
  int out = -1, err = -1;
};

/// Runs `cogrsim ARGS` and sends `signal` as soon as `at_work` says so; its output is read after
/// that. `full`: until then there is no space for anything on its standard output.
Outcome cogrsim_interrupted(const std::vector<std::string>& args, int signal,
                            const std::function<bool(const RunningProgram&)>& at_work,
                            bool full = false);

/// The same on a terminal of its own: `out` is all that appears there. `environment`: "NAME=value".
Outcome cogrsim_on_terminal(const std::vector<std::string>& args,
                            const std::vector<std::string>& environment = {});

/// The subcommands that `cogrsim --help` lists.
std::set<std::string> listed_commands();

using TemporaryFolder = cogrsim::test::TemporaryFolder;

std::string read_file(const std::string& path);
