// Compiles a scene for a subcommand, and turns its diagnostics into text and JSON.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"
#include "common/json_text.h"
#include "common/options.h"

namespace cogrsim::cli {

struct LoadedScene {
  std::shared_ptr<PluginLoader> loader;
  SceneModelPtr model;                  ///< nullptr: there are errors
  std::vector<Diagnostic> diagnostics;  ///< errors and warnings
  std::vector<std::string> files_read;  ///< see dsl::CompileResult
};

/// Compiles the scene with the plugins found in the usual folders and those given.
LoadedScene load_scene(const SceneOptions& options);

/// The names of all backends that the loader finds, sorted.
std::vector<std::string> installed_backends(const std::shared_ptr<PluginLoader>& loader);
/// Those in libraries, which every build has: where a command names none. Those in processes of their own
/// are named, or meant by "all".
std::vector<std::string> library_backends(const std::shared_ptr<PluginLoader>& loader);

/// `asked` with all backends that run the scene in place of the word "all", behind those that are named.
/// Which are left out, and why, is a note in the scene's diagnostics, and printed.
std::vector<std::string> expand_all(const std::vector<std::string>& asked,
                                    const std::vector<std::string>& without, LoadedScene& scene);

/// The run's length [s]: the option, else the scene's own, else 10 s.
double duration_of(const SceneModel& model, const SceneOptions& options);

/// Empty, or why `step` and `duration` [s] do not fit together, with the remedy.
std::string step_problem(double step, double duration);

Json to_json(const Diagnostic& diagnostic);
/// The same keys as a finding's, with `time` and `source` filled in.
Json to_json(const RunMessage& message);
Json diagnostics_json(const std::vector<Diagnostic>& diagnostics,
                      const std::vector<RunMessage>& messages);

/// Findings in compiler style, each with the line it points at.
std::string diagnostics_text(std::vector<Diagnostic> diagnostics, bool color);
/// Prints findings to stderr, compiler style, in colour on a terminal.
void print_diagnostics(const std::vector<Diagnostic>& diagnostics);
/// Prints what Simulation::create() refuses to stderr: what has no code as plain errors first.
void print_problems(const std::vector<Diagnostic>& problems);
/// "at 1.2 s, bot.driver: …", for a terminal. `run`: which of several.
std::string message_text(const RunMessage& message, const std::string& run = {});
/// That behind "error: " or "warning: ", to stderr.
void print_message(const RunMessage& message, const std::string& run = {});
/// Which messages of one run are printed: the first 20 errors and, so that notes never crowd them
/// out, the first 20 others. The rest are in the JSON.
class MessageBudget {
 public:
  /// Whether this one, the next of the run, is to be printed.
  bool takes(const RunMessage& message);
  /// How many were not.
  std::size_t left_out() const { return left_out_; }
  /// That, if any were not, to stderr.
  void print_rest() const;

 private:
  std::size_t errors_ = 0, others_ = 0, left_out_ = 0;
};
/// Prints those that MessageBudget takes, and the number of the others.
void print_messages(const std::vector<RunMessage>& messages, const std::string& run = {});

}  // namespace cogrsim::cli
