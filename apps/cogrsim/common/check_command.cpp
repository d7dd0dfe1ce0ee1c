// cogrsim check, explain, schema: the commands that need only the scene compiler.
#include <unistd.h>
#include <algorithm>
#include <cstdio>

#include <fmt/format.h>

#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/dsl/schema.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/warnings.h"
#include "cogrsim/plugin/crash_report.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

int print_or_fail(const std::string& text, int status) {
  if (const auto printed = print_output(text); !printed) {
    return refuse(printed.error());
  }
  return status;
}

bool is_error(const Diagnostic& diagnostic) { return diagnostic.severity == Severity::error; }

std::string contents_text(const SceneModel& model) {
  return fmt::format("{}, {}, {}, {}", count_text(model.bodies.size(), "body", "bodies"),
                     count_text(model.joints.size(), "joint", "joints"),
                     count_text(model.motors.size(), "motor", "motors"),
                     count_text(model.sensors.size(), "sensor", "sensors"));
}

// The diagnostics of the backend that would run the scene: the one asked for, else the scene's own.
void check_backend(const CheckOptions& options, LoadedScene& scene) {
  const std::string& asked = options.backend;
  const std::string name = asked.empty() ? scene.model->physics.backend : asked;
  if (name.empty()) return;
  const auto backend = scene.loader->backend(name);
  if (!backend) {
    Diagnostic diagnostic = to_diagnostic(backend.error());
    if (asked.empty()) {
      diagnostic.locate(source_position(*scene.model, scene.model->physics.backend_origin));
    }
    scene.diagnostics.push_back(std::move(diagnostic));
    return;
  }
  scene.model = leave_out(scene.model, (*backend)->capabilities(), options.without);
  for (Diagnostic& diagnostic :
       check_capabilities(*scene.model, name, (*backend)->capabilities())) {
    scene.diagnostics.push_back(std::move(diagnostic));
  }
  for (Diagnostic& d : stiff_forces(*scene.model)) scene.diagnostics.push_back(std::move(d));
  if (std::any_of(scene.diagnostics.begin(), scene.diagnostics.end(), is_error)) return;
  // What stops a world from being made is for the run to say, which knows all options.
  const PluginCall call("backend", (*backend)->name(), "", "", "while the world was created");
  const auto world = (*backend)->create_world(scene.model);
  if (auto* const said = world ? (*world)->extension<WorldWarnings>() : nullptr)
    for (Diagnostic& d : said->warnings()) scene.diagnostics.push_back(std::move(d));
}

}  // namespace

int check_command(const CheckOptions& options) {
  const bool color = !style_of(fileno(standard_output())).off.empty();
  const Style style = style_of(fileno(standard_output()));
  std::vector<Diagnostic> all;
  std::string out;
  std::size_t errors = 0;
  for (const std::string& path : options.scenes) {
    SceneOptions scene_options;
    scene_options.scene = path;
    scene_options.set = options.set;
    scene_options.plugin_paths = options.plugin_paths;
    LoadedScene scene = load_scene(scene_options);
    if (scene.model) check_backend(options, scene);
    const auto found = static_cast<std::size_t>(
        std::count_if(scene.diagnostics.begin(), scene.diagnostics.end(), is_error));
    const std::size_t warnings = scene.diagnostics.size() - found;
    errors += found;
    out += diagnostics_text(scene.diagnostics, color);
    if (!is_quiet()) {
      if (found > 0) {
        out += fmt::format("{}: {}{}{}", one_line(path), style.red,
                           count_text(found, "error", "errors"), style.off);
      } else {
        out += fmt::format("{}: {}good{}, {}", one_line(path), style.green, style.off,
                           contents_text(*scene.model));
      }
      if (warnings > 0) out += ", " + count_text(warnings, "warning", "warnings");
      out += "\n";
    }
    all.insert(all.end(), scene.diagnostics.begin(), scene.diagnostics.end());
  }
  const auto ended = [](std::string lines) {
    if (!lines.empty() && lines.back() != '\n') lines += '\n';
    return lines;
  };
  if (options.sarif) out = dsl::to_sarif(all);
  if (!options.json.empty()) {
    const auto written = write_output(options.json, OutputKind::json, ended(dsl::to_json(all)));
    if (!written) return refuse(written.error());
    if (options.json == "-") out.clear();
  }
  return print_or_fail(ended(out), errors == 0 ? kGood : kFailed);
}

int explain_command(const std::string& code) {
  if (code.empty()) {
    // The first line of an explanation is its title.
    std::string out;
    for (const std::string& known : dsl::diagnostic_codes()) {
      const std::string text = dsl::explain(known);
      const std::string title = text.substr(0, text.find('\n'));
      out += title.find(known) == std::string::npos ? known + "  " + title + "\n" : title + "\n";
    }
    return print_or_fail(out, kGood);
  }
  std::string wanted = code;
  for (char& c : wanted) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  std::string text = dsl::explain(wanted);
  if (text.empty()) {
    const std::string nearest = nearest_name(wanted, dsl::diagnostic_codes());
    print_error(
        fmt::format("there is no code '{}'\nhelp: {}cogrsim explain, without a code, lists "
                    "them all",
                    code, nearest.empty() ? "" : fmt::format("did you mean {}? ", nearest)));
    return kWrongUsage;
  }
  if (text.back() != '\n') text += '\n';
  return print_or_fail(text, kGood);
}

int schema_command(bool reference, const std::string& json,
                   const std::vector<std::string>& plugin_paths) {
  if (reference) return print_or_fail(dsl::write_reference_markdown(), kGood);
  dsl::LoaderCatalog catalog(std::make_shared<PluginLoader>(plugin_paths));
  if (!json.empty()) {
    const auto written =
        write_output(json, OutputKind::json, dsl::write_schema_json(&catalog) + "\n");
    return written ? kGood : refuse(written.error());
  }
  return print_or_fail(dsl::write_xsd(&catalog), kGood);
}

}  // namespace cogrsim::cli
