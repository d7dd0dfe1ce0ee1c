// One run of a study, in a process of its own: a crash ends only this run.
#pragma once

#include <string>

#include "common/json_text.h"

namespace cogrsim::cli {

/// The descriptor on which the child writes its result: plugins may print to the standard output.
inline constexpr int kResultDescriptor = 3;

/// The hidden subcommand: reads what to run from the standard input (SweepPlan::input()), runs it,
/// and writes the result to kResultDescriptor.
int sweep_case_command();

/// A result that no run made: `status` "crashed", "timeout", "memory" or "failed", and why.
Json failed_result(const std::string& status, const std::string& cause);

}  // namespace cogrsim::cli
