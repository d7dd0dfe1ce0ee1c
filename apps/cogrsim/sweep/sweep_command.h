// cogrsim sweep: parameter studies.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/case_pool.h"
#include "sweep/sweep_plan.h"

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds `sweep`, and the hidden `sweep-case` that its children are; see add_info().
void add_sweep(CLI::App& app, int& status);

/// NAME=VALUES of `--vary`; throws UsageError.
dsl::Study::Variation variation_from(const std::string& argument);
/// `--backends`, split and without doubles; throws UsageError.
std::vector<std::string> backends_from(const std::vector<std::string>& lists);
/// Wall-clock or simulated time above 0 [s]; throws UsageError.
double seconds_from(const char* option, const std::string& argument);

/// `--jobs`, `--timeout`, `--retry` and `--dry-run`; the text of the timeout is for seconds_from().
void add_processes(CLI::App& command, SweepOptions& options, std::string& timeout);

/// What its processes may do; without `--jobs` so many at a time as there are cores, or `jobs`.
CasePool::Limits case_limits(const SweepOptions& options, std::optional<int> jobs = std::nullopt);

int sweep_command(const SweepOptions& options);

/// Another command whose runs are gathered as those of a sweep are.
struct Study {
  std::string title = "sweep";                     ///< of the line of progress
  std::function<std::optional<SweepPlan>()> make;  ///< prints its errors; nullopt then
  /// Tells of the runs that are in the table, and what each backend left out; its exit status. Empty:
  /// the sweep's own lines.
  std::function<int(const SweepPlan&, const std::string&)> report;
  bool kept = true;  ///< the table stays
};
/// Runs it, here or spread by mpirun; an exit status.
int run_study(const SweepOptions& options, const Study& study);

/// "sweep  [#####-----]  42 of 100  3 failed  1 min 03 s left": as Progress, counted in runs.
std::string sweep_line(std::size_t done, std::size_t failed, std::size_t before, std::size_t all,
                       double elapsed, int width, const std::string& title = "sweep");

}  // namespace cogrsim::cli
