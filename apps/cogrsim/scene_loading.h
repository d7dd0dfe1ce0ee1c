// Compiles a scene for a subcommand, and turns what was found into text and JSON.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"
#include "json_text.h"
#include "options.h"

namespace cogrsim::cli {

struct LoadedScene {
  std::shared_ptr<PluginLoader> loader;
  SceneModelPtr model;                  ///< nullptr: there are errors
  std::vector<Diagnostic> diagnostics;  ///< errors and advice
  std::vector<std::string> files_read;  ///< see dsl::CompileResult
};

/// Compiles the scene with the plugins found in the usual folders and those given.
LoadedScene load_scene(const SceneOptions& options);

/// The run's length [s]: what was asked for, else the scene's own, else 10 s.
double duration_of(const SceneModel& model, const SceneOptions& options);

/// Empty, or why `step` and `duration` [s] do not go together, with the way out.
std::string step_problem(double step, double duration);

/// An error without a place in a file as a finding; `where` becomes a note.
Diagnostic to_diagnostic(const Error& error);

Json to_json(const Diagnostic& diagnostic);
/// The same keys as a finding's, with `time` and `source` filled in.
Json to_json(const RunMessage& message);
Json diagnostics_json(const std::vector<Diagnostic>& diagnostics,
                      const std::vector<RunMessage>& messages);

/// Findings in compiler style, each with the line it points at.
std::string diagnostics_text(std::vector<Diagnostic> diagnostics, bool color);
/// Prints findings to stderr, compiler style, in colour on a terminal.
void print_diagnostics(const std::vector<Diagnostic>& diagnostics);
/// "at 1.2 s, bot.driver: …", for a terminal. `run`: which of several.
std::string message_text(const RunMessage& message, const std::string& run = {});
/// That behind "error: " or "advice: ", to stderr.
void print_message(const RunMessage& message, const std::string& run = {});
/// Which messages of one run the user is shown: the first 20 errors and, so that these are told however
/// many remarks there are, as many others. The rest are in the JSON.
class MessageBudget {
 public:
  /// Whether this one, the next of the run, is to be printed.
  bool takes(const RunMessage& message);
  /// How many were not.
  std::size_t left_out() const { return left_out_; }
  /// That, if any were not, to stderr.
  void tell_rest() const;

 private:
  std::size_t errors_ = 0, others_ = 0, left_out_ = 0;
};
/// What MessageBudget takes of them, and how many more there are.
void print_messages(const std::vector<RunMessage>& messages, const std::string& run = {});

}  // namespace cogrsim::cli
