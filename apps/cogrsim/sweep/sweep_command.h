// cogrsim sweep: parameter studies.
#pragma once

#include <string>

#include "sweep/sweep_plan.h"

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds `sweep`, and the hidden `sweep-case` that its children are; see add_info().
void add_sweep(CLI::App& app, int& status);

int sweep_command(const SweepOptions& options);

/// "sweep  [#####-----]  42 of 100  3 failed  1 min 03 s left": as Progress, counted in runs.
std::string sweep_line(std::size_t done, std::size_t failed, std::size_t before, std::size_t all,
                       double elapsed, int width);

}  // namespace cogrsim::cli
