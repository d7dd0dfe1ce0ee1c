#include "common/scene_loading.h"

#include <unistd.h>
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "cogrsim/dsl/loader_catalog.h"
#include "common/output_file.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

// The keys every entry of a "diagnostics" array has.
Json empty_finding() {
  return {{"severity", "error"},    {"code", nullptr},   {"message", ""},     {"file", nullptr},
          {"line", nullptr},        {"column", nullptr}, {"length", nullptr}, {"help", nullptr},
          {"notes", Json::array()}, {"time", nullptr},   {"source", nullptr}};
}

// The line a finding of the run points at. The compiler brings its own excerpts; plugins and
// engines know only the source location.
std::string source_line(const Diagnostic& diagnostic) {
  constexpr std::size_t kLongest = 4000;  // [bytes]; a longer line is a machine's
  std::error_code error;
  if (!std::filesystem::is_regular_file(diagnostic.file, error)) return {};
  std::ifstream in(diagnostic.file, std::ios::binary);
  std::string line;
  for (int i = 0; i < diagnostic.line; ++i) {
    if (!std::getline(in, line)) return {};
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line.size() > kLongest ? std::string() : line;
}

}  // namespace

LoadedScene load_scene(const SceneOptions& options) {
  LoadedScene scene;
  scene.loader = std::make_shared<PluginLoader>(options.plugin_paths);
  dsl::LoaderCatalog catalog(scene.loader);
  dsl::CompileOptions compile;
  compile.set_parameters = options.set;
  compile.seed = options.seed;
  compile.plugins = &catalog;
  dsl::CompileResult result = dsl::compile_file(options.scene, compile);
  scene.model = std::move(result.model);
  scene.diagnostics = std::move(result.diagnostics);
  scene.files_read = std::move(result.files_read);
  for (const std::string& file : scene.files_read) add_input(file);
  return scene;
}

std::vector<std::string> installed_backends(const std::shared_ptr<PluginLoader>& loader) {
  return dsl::LoaderCatalog(loader).names(PluginKind::backend);
}

std::vector<std::string> library_backends(const std::shared_ptr<PluginLoader>& loader) {
  std::vector<std::string> out;
  for (const PluginPtr& plugin : loader->all())
    if (plugin->descriptor().kind == PluginKind::backend && !plugin->is_program())
      out.push_back(plugin->descriptor().name);
  return out;
}

std::vector<std::string> expand_all(const std::vector<std::string>& asked,
                                    const std::vector<std::string>& without, LoadedScene& scene) {
  std::vector<std::string> out = asked;
  const auto end = std::remove(out.begin(), out.end(), "all");
  if (end == out.end()) return asked;
  out.erase(end, out.end());
  std::vector<Diagnostic> notes;
  const auto leave_out = [&](const std::string& name, const std::string& reason) {
    Diagnostic& note = notes.emplace_back();
    note.severity = Severity::note;
    note.message = fmt::format("of all backends '{}' is left out: {}", name, reason);
  };
  std::vector<RefusedPlugin> refused;
  for (const PluginPtr& plugin : scene.loader->all(&refused)) {
    const PluginDescriptor& about = plugin->descriptor();
    if (about.kind != PluginKind::backend || std::count(out.begin(), out.end(), about.name) > 0)
      continue;
    SimulationOptions trial;
    trial.backend = about.name;
    trial.without = without;
    if (const auto made = Simulation::create(scene.model, trial, scene.loader)) {
      out.push_back(about.name);
      continue;
    } else {
      const auto is_error = [](const Diagnostic& d) { return d.severity == Severity::error; };
      const auto& found = made.error();
      const auto first = std::find_if(found.begin(), found.end(), is_error);
      const auto rest = std::count_if(found.begin(), found.end(), is_error) - 1;
      leave_out(about.name, (first == found.end() ? "it cannot be created" : first->message) +
                                (rest > 0 ? fmt::format(", and {} more", rest) : ""));
    }
  }
  for (const RefusedPlugin& one : refused)
    if (!one.unavailable.empty()) leave_out(one.unavailable, one.reason);
  print_diagnostics(notes);
  scene.diagnostics.insert(scene.diagnostics.end(), notes.begin(), notes.end());
  return out;
}

double duration_of(const SceneModel& model, const SceneOptions& options) {
  if (options.duration) return *options.duration;
  return model.physics.duration.value_or(kDefaultDuration);
}

std::string step_problem(double step, double duration) {
  if (duration >= step * (1.0 - 1e-9)) return {};
  return fmt::format(
      "a duration of {} is shorter than one step of {}\n"
      "help: ask for a longer --duration or a smaller --step",
      time_text(duration), step_text(step));
}

Json to_json(const Diagnostic& diagnostic) {
  Json out = empty_finding();
  out["severity"] = severity_name(diagnostic.severity);
  out["code"] = text_or_null(diagnostic.code);
  out["message"] = diagnostic.message;
  out["help"] = text_or_null(diagnostic.help);
  if (!diagnostic.file.empty()) {
    out["file"] = diagnostic.file;
    out["line"] = diagnostic.line;
    out["column"] = diagnostic.column;
    out["length"] = diagnostic.length;
  }
  for (const DiagnosticNote& note : diagnostic.notes) {
    out["notes"].push_back({{"message", note.message},
                            {"file", text_or_null(note.file)},
                            {"line", note.line},
                            {"column", note.column}});
  }
  return out;
}

Json to_json(const RunMessage& message) {
  Json out = empty_finding();
  out["severity"] = severity_name(message.severity);
  out["message"] = message.message;
  out["time"] = message.time;
  out["source"] = text_or_null(message.source);
  return out;
}

Json diagnostics_json(const std::vector<Diagnostic>& diagnostics,
                      const std::vector<RunMessage>& messages) {
  Json out = Json::array();
  for (const Diagnostic& diagnostic : diagnostics) out.push_back(to_json(diagnostic));
  for (const RunMessage& message : messages) out.push_back(to_json(message));
  return out;
}

std::string diagnostics_text(std::vector<Diagnostic> diagnostics, bool color) {
  for (Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.source_line.empty() && diagnostic.line > 0) {
      diagnostic.source_line = source_line(diagnostic);
    }
  }
  std::string text = dsl::to_text(diagnostics, color);
  if (!text.empty() && text.back() != '\n') text += '\n';
  return text;
}

void print_problems(const std::vector<Diagnostic>& problems) {
  std::vector<Diagnostic> coded;
  for (const Diagnostic& d : problems) {
    if (d.code.empty())
      print_error(to_error(d).text());
    else
      coded.push_back(d);
  }
  print_diagnostics(coded);
}

void print_diagnostics(const std::vector<Diagnostic>& diagnostics) {
  const bool color = !style_of(STDERR_FILENO).off.empty();
  std::fputs(diagnostics_text(diagnostics, color).c_str(), stderr);
}

std::string message_text(const RunMessage& message, const std::string& run) {
  std::string text = run.empty() ? "" : run + ", ";
  // A message from before the start has no time worth printing.
  if (message.time > 0.0) text += "at " + time_text(message.time) + ", ";
  if (!message.source.empty()) text += one_line(message.source) + ": ";
  return text + paragraph(message.message);
}

void print_message(const RunMessage& message, const std::string& run) {
  const Style style = style_of(STDERR_FILENO);
  const bool error = message.severity == Severity::error;
  const std::string text = (error ? style.red : style.cyan) +
                           std::string(severity_name(message.severity)) + ":" + style.off + " " +
                           message_text(message, run) + "\n";
  std::fputs(text.c_str(), stderr);
}

bool MessageBudget::takes(const RunMessage& message) {
  constexpr std::size_t kMost = 20;
  std::size_t& printed = message.severity == Severity::error ? errors_ : others_;
  const bool taken = printed < kMost;
  ++(taken ? printed : left_out_);
  return taken;
}

void MessageBudget::print_rest() const {
  if (left_out_ == 0) return;
  std::fputs(fmt::format("and {} more messages, see --json\n", left_out_).c_str(), stderr);
}

void print_messages(const std::vector<RunMessage>& messages, const std::string& run) {
  MessageBudget budget;
  for (const RunMessage& message : messages) {
    if (budget.takes(message)) print_message(message, run);
  }
  budget.print_rest();
}

}  // namespace cogrsim::cli
