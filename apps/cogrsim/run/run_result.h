// The result of a run, as JSON and as a summary.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/physics/provenance.h"
#include "cogrsim/simulation/simulation.h"
#include "common/json_text.h"
#include "run/run_measures.h"
#include "common/terminal.h"

namespace cogrsim::cli {

struct RunResult {
  std::string scene;  ///< its name; empty when it did not compile
  std::string file;
  std::string backend;
  std::string engine_version;
  std::optional<Provenance> provenance;  ///< empty: it never started
  std::uint64_t seed = 0;
  std::map<std::string, std::string> set;  ///< `--set`
  std::string status = "failed";           ///< to_string(RunStatus), or "failed": it never started
  double step = 0.0;                       ///< [s]
  std::uint64_t steps = 0;
  double time = 0.0;       ///< [s]
  double wall_time = 0.0;  ///< of stepping alone [s]
  FramePtr frame;          ///< the last one; nullptr: it never started
  std::vector<Diagnostic> diagnostics;
  std::vector<RunMessage> messages;
  std::vector<Event> events;                 ///< of the whole run, the first RunLog::kMostEvents
  std::uint64_t events_left_out = 0;         ///< that came after those
  std::vector<RunMeasures::Value> measures;  ///< the scene's own
};

/// The contract other programs read: all keys, always; unknown values are null or empty.
Json to_json(const RunResult& result);

/// For people: how it ended, then the bodies and joints at the end.
std::string summary_text(const RunResult& result, const Style& style);

}  // namespace cogrsim::cli
