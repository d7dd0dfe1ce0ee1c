// One run of a study, in a process of its own: a crash ends only this run.
#pragma once

#include <string>

#include "cogrsim/simulation/simulation.h"
#include "common/case_pool.h"
#include "common/json_text.h"

namespace cogrsim::cli {

/// The hidden subcommand: runs a case_input() that SweepPlan::input() wrote.
int sweep_case_command();

/// The result of a case that ended; a failed_result() if it ended without one.
Json sweep_outcome(CaseEnd end, const CasePool::Limits& limits);

/// The result of a run that ended, without measures. `wall`: time that it took [s].
Json ended_result(Simulation& simulation, RunStatus status, double wall);
/// The first error, with its code and place.
std::string refusal_text(const std::vector<Diagnostic>& diagnostics);

/// A result that no run made: `status` "crashed", "timeout", "memory" or "failed", and why.
Json failed_result(const std::string& status, const std::string& cause);

}  // namespace cogrsim::cli
