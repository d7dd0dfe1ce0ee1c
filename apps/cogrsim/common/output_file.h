// Outputs of a command: the SDK's rule for files (cogrsim/core/output_file.h) with the options of
// this command line, and the standard output.
#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/output_file.h"

namespace cogrsim::cli {

/// `--overwrite` was given.
void allow_overwriting();
/// No output of this command may be this file. From any thread.
void add_input(const std::string& path);
/// The files that this command's outputs may replace.
OutputRules output_rules();
/// The same for outputs that a scene names: inside `folder`.
OutputRules scene_rules(const std::string& folder);

/// Whether a file of this name could be written, asked before a long run starts. "-" is stdout.
Result<> check_writable(const std::string& path, OutputKind kind);
/// The same for several; empty names are none. To be asked again once all inputs are known.
Result<> check_writable(const std::vector<std::pair<std::string, OutputKind>>& outputs);

/// Writes `text` whole or not at all; "-" is stdout. Errors: as check_writable, disk full; `path` is
/// then as it was.
Result<> write_output(const std::string& path, OutputKind kind, const std::string& text);

/// Keeps the standard output for this program's own results: output of plugins and engines
/// goes to the standard error from now on. Called once, before the first plugin is loaded.
void claim_standard_output();
/// Where results are printed; its descriptor shows whether that is a terminal.
std::FILE* standard_output();

/// Prints a result that was asked for to stdout, and makes sure it arrived.
Result<> print_output(const std::string& text);

/// `--quiet` was given: no progress, and no text for people but warnings and errors.
void be_quiet();
bool is_quiet();
/// The same for text that people read, which `--quiet` leaves out.
Result<> print_report(const std::string& text);
/// What a command found: as JSON where `--json` says (a file, "-" or, empty, nowhere), and as text
/// for people unless the standard output has the JSON.
Result<> print_found(const std::string& json, const std::function<std::string()>& as_json,
                     const std::function<std::string()>& as_text);

}  // namespace cogrsim::cli
