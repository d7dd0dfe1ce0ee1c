// One case of `cogrsim test`: a test of a scene with one seed, on one backend, or on several in
// lockstep where their results must agree. Runs in a process of its own.
#pragma once

#include <string>

#include "common/json_text.h"

namespace cogrsim::cli {

/// Result of a case that did not come to a verdict, and why.
Json no_result(const std::string& message);

/// The hidden subcommand: runs a case_input() and writes its result, always, unless it crashes.
///
/// Input: scene, set {}, plugin_paths [], without [], test (its number in the scene), backends [], seed (null:
/// the scene's), overwrite, recording (path without ending; "" for none).
/// Result: status "passed", "failed" or "error"; message; verdicts [{expectation, passed, message,
/// time, file, line, column, columns, samples, text}]; left_out {backend: text}, if there is
/// any; recordings []; simulated [s].
int test_case_command();

}  // namespace cogrsim::cli
