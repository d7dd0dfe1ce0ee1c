// Runs the program as a user's shell would.
#pragma once

#include <string>
#include <vector>

#include "../support/temporary_folder.h"

/// How a program ended and what it said.
struct Outcome {
  int status = -1;  ///< exit status; 128 + n: killed by signal n
  std::string out, err;
};

/// Runs `cogrsim ARGS`, both streams piped. `interrupt_after` [s]: sends Ctrl-C then; 0: never.
Outcome cogrsim_run(const std::vector<std::string>& args, double interrupt_after = 0.0);

/// The same for somebody whom permissions stop: as the user "nobody" where the test runs as root. Status 127: that user
/// cannot reach the program.
Outcome cogrsim_run_unprivileged(const std::vector<std::string>& args);

/// The same on a terminal of its own: `out` is all that appears there. `environment`: "NAME=value".
Outcome cogrsim_on_terminal(const std::vector<std::string>& args,
                            const std::vector<std::string>& environment = {});

using TemporaryFolder = cogrsim::test::TemporaryFolder;

std::string read_file(const std::string& path);
