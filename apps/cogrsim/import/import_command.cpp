#include "import/import_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "common/arguments.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "compare/zoom_chart.h"

namespace cogrsim::cli {

namespace fs = std::filesystem;

namespace {

struct ImportCommandOptions {
  std::string file, output, report;
  bool strict = false;
  dsl::ImportOptions import;
};

std::string position_of(const dsl::ImportEntry& e) {
  return e.file.empty() ? "" : fmt::format("{}:{}:{}", e.file, e.line, e.column);
}

/// What is not exact, the first 20 of each kind.
void print_report(const dsl::ImportResult& result, const Style& style) {
  using dsl::Fidelity;
  for (const Fidelity fidelity : {Fidelity::approximate, Fidelity::left_out}) {
    const std::size_t count = result.count(fidelity);
    if (count == 0) continue;
    std::string text = fmt::format("{}{}{}, {}:\n", style.cyan, dsl::fidelity_name(fidelity),
                                   style.off, count_text(count, "element", "elements"));
    constexpr std::size_t kMost = 20;
    std::size_t shown = 0;
    for (const dsl::ImportEntry& e : result.entries) {
      if (e.fidelity != fidelity) continue;
      if (++shown > kMost) break;
      text += fmt::format("  {}{}{}: {}\n", position_of(e), e.file.empty() ? "" : ": ", e.element,
                          e.message);
    }
    if (count > kMost)
      text += fmt::format("  and {} more; --report FILE.html lists all\n", count - kMost);
    std::fputs(printable(text).c_str(), stderr);
  }
}

int import_command(const ImportCommandOptions& options) {
  add_input(options.file);
  for (const auto& [path, kind] :
       {std::pair{options.output, OutputKind::xml},
        std::pair{options.report,
                  options.report.ends_with(".html") ? OutputKind::html : OutputKind::json}})
    if (!path.empty())
      if (const auto writable = check_writable(path, kind); !writable)
        return refuse(writable.error());
  std::error_code missing;
  if (!fs::is_regular_file(options.file, missing))
    return refuse(Error(fmt::format("there is no file '{}'", options.file), "",
                        "name a URDF, xacro, MJCF or SDF file"));
  dsl::ImportOptions import = options.import;
  const fs::path output =
      options.output.empty() || options.output == "-" ? fs::path("x") : fs::path(options.output);
  std::error_code fault;
  import.scene_folder =
      fs::weakly_canonical(output.parent_path().empty() ? fs::path(".") : output.parent_path(),
                           fault)
          .string();
  const dsl::ImportResult result = dsl::import_model(options.file, import);
  print_diagnostics(result.diagnostics);
  if (!options.report.empty()) {
    const bool html = options.report.ends_with(".html");
    if (const auto written = html ? write_output(options.report, OutputKind::html,
                                                 fidelity_html(result, options.file))
                                  : write_output(options.report, OutputKind::json,
                                                 json_text(fidelity_json(result, options.file)));
        !written)
      return refuse(written.error());
  }
  if (result.scene.empty()) {
    print_error(fmt::format("'{}' could not be imported", options.file));
    return kFailed;
  }
  print_report(result, style_of(STDERR_FILENO));
  const std::size_t lost = result.count(dsl::Fidelity::left_out);
  if (options.strict && lost > 0) {
    print_error(fmt::format("{} left out, and --strict allows none; nothing was written",
                            count_text(lost, "element was", "elements were")));
    return kFailed;
  }
  for (const dsl::ImportedFile& file : result.files) {
    const fs::path path = fs::path(import.scene_folder) / file.name;
    fs::create_directories(path.parent_path(), fault);
    // A mesh that is there already with these bytes is the one that is meant.
    if (std::ifstream there(path, std::ios::binary);
        there &&
        std::equal(std::istreambuf_iterator<char>(there), {}, file.bytes.begin(), file.bytes.end()))
      continue;
    if (const auto written =
            write_output_file(path.string(), OutputKind::other, file.bytes, output_rules());
        !written)
      return refuse(written.error());
  }
  if (options.output.empty() || options.output == "-") {
    if (const auto printed = print_output(result.scene); !printed) return refuse(printed.error());
  } else if (const auto written = write_output(options.output, OutputKind::xml, result.scene);
             !written) {
    return refuse(written.error());
  }
  // What was written is a scene, or that is our mistake: say so at once.
  if (!options.output.empty() && options.output != "-") {
    SceneOptions scene;
    scene.scene = options.output;
    const LoadedScene loaded = load_scene(scene);
    std::vector<Diagnostic> errors;
    for (const Diagnostic& d : loaded.diagnostics)
      if (d.severity == Severity::error) errors.push_back(d);
    print_diagnostics(errors);
    if (!loaded.model) {
      print_error(fmt::format("'{}' was written, and is not a valid scene", options.output));
      return kFailed;
    }
    std::fputs(
        printable(fmt::format("{}: {}; {} exact, {} approximate, {} left out\n", options.output,
                              count_text(loaded.model->bodies.size(), "body", "bodies") + ", " +
                                  count_text(loaded.model->joints.size(), "joint", "joints"),
                              result.count(dsl::Fidelity::exact),
                              result.count(dsl::Fidelity::approximate), lost))
            .c_str(),
        stderr);
  }
  return kGood;
}

}  // namespace

Json fidelity_json(const dsl::ImportResult& result, const std::string& source) {
  Json entries = Json::array();
  for (const dsl::ImportEntry& e : result.entries)
    entries.push_back({{"fidelity", dsl::fidelity_name(e.fidelity)},
                       {"element", e.element},
                       {"message", e.message},
                       {"file", e.file},
                       {"line", e.line},
                       {"column", e.column}});
  return {{"source", source},
          {"format", result.format},
          {"imported", !result.scene.empty()},
          {"exact", result.count(dsl::Fidelity::exact)},
          {"approximate", result.count(dsl::Fidelity::approximate)},
          {"left_out", result.count(dsl::Fidelity::left_out)},
          {"entries", std::move(entries)},
          {"diagnostics", Json::parse(dsl::to_json(result.diagnostics))}};
}

std::string fidelity_html(const dsl::ImportResult& result, const std::string& source) {
  std::string out = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Import of "
      "{0}</title>\n"
      "<style>body{{font:15px/1.5 system-ui,sans-serif;max-width:70em;margin:2em auto;padding:0 "
      "1em}}"
      "table{{border-collapse:collapse;width:100%}}td,th{{text-align:left;padding:.25em .6em;"
      "border-bottom:1px solid #ddd;vertical-align:top}}.exact{{color:#2a7a2a}}"
      ".approximate{{color:#9a6a00}}.left{{color:#b02a2a}}</style></head><body>\n"
      "<h1>Import of {0}</h1>\n<p>{1}: <b class=\"exact\">{2} exact</b>, "
      "<b class=\"approximate\">{3} approximate</b>, <b class=\"left\">{4} left out</b></p>\n",
      html_escaped(source), html_escaped(result.format.empty() ? "not imported" : result.format),
      result.count(dsl::Fidelity::exact), result.count(dsl::Fidelity::approximate),
      result.count(dsl::Fidelity::left_out));
  for (const Diagnostic& d : result.diagnostics)
    out += fmt::format("<p class=\"left\"><b>{}:{}:{}: {}</b> {}</p>\n", html_escaped(d.file),
                       d.line, d.column, html_escaped(d.message), html_escaped(d.help));
  out += "<table><tr><th>fidelity</th><th>element</th><th>note</th><th>source</th></tr>\n";
  using dsl::Fidelity;
  for (const Fidelity fidelity : {Fidelity::left_out, Fidelity::approximate, Fidelity::exact})
    for (const dsl::ImportEntry& e : result.entries)
      if (e.fidelity == fidelity)
        out += fmt::format("<tr><td class=\"{}\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                           fidelity == Fidelity::left_out ? "left" : dsl::fidelity_name(fidelity),
                           dsl::fidelity_name(fidelity), html_escaped(e.element),
                           html_escaped(e.message), html_escaped(position_of(e)));
  return out + "</table></body></html>\n";
}

void add_import(CLI::App& app, int& status) {
  struct Arguments {
    ImportCommandOptions options;
    std::vector<std::string> packages, arguments;
    std::string drives = "none";
    bool no_floor = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  ImportCommandOptions& o = arguments->options;
  CLI::App& command = *app.add_subcommand(
      "import", "Convert a robot or world from URDF, xacro, MJCF or SDF into a scene");
  command.add_option("file", o.file, "URDF, xacro, MJCF or SDF file")
      ->required()
      ->type_name("FILE");
  command.add_option("-o,--output", o.output, "Scene to write; default: print it")
      ->type_name("NAME.scene.xml");
  add_list(command, "--package", arguments->packages,
           "Folder of a ROS package, for package:// and $(find …); may be repeated", "NAME=DIR");
  add_list(command, "--arg", arguments->arguments, "Value of a xacro argument; may be repeated",
           "NAME=VALUE");
  command
      .add_option("--srdf", o.import.semantics, "SRDF file with pairs of links that do not collide")
      ->type_name("FILE");
  command
      .add_option("--drives", arguments->drives, "Motors for the joints of a source that has none")
      ->check(CLI::IsMember({"none", "position", "torque", "velocity"}))
      ->type_name("none|position|torque|velocity");
  command.add_flag("--fixed-base", o.import.fixed_base, "The root link is static");
  command.add_flag("--no-floor", arguments->no_floor, "Add no floor below the robot");
  command
      .add_option("--copy-meshes", o.import.copy_meshes,
                  "Copy all meshes into this folder beside the scene; default: only those that the "
                  "scene cannot refer to, into meshes")
      ->type_name("DIR");
  command
      .add_option("--report", o.report,
                  "Write what is exact, approximate and left out, element by element")
      ->type_name("FILE.json|.html");
  command.add_flag("--strict", o.strict, "Fail if anything is left out");
  command.footer(
      "Examples:\n"
      "  cogrsim import robot.urdf -o robot.scene.xml\n"
      "  cogrsim import arm.urdf.xacro -o arm.scene.xml --package "
      "arm_description=../arm_description\n"
      "  cogrsim import humanoid.xml -o humanoid.scene.xml --report humanoid.html\n"
      "Then: cogrsim run robot.scene.xml, or cogrsim studio robot.scene.xml\n"
      "Exit status 0 imported, 1 not imported, 2 wrong usage.");
  command.callback([&status, arguments] {
    ImportCommandOptions& options = arguments->options;
    const auto pairs = [](const std::vector<std::string>& from, const char* name,
                          std::map<std::string, std::string>& to) {
      for (const std::string& text : from) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0)
          throw UsageError(name, Error("'" + text + "' is not NAME=VALUE"));
        if (!to.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
          throw UsageError(name, Error("'" + text.substr(0, equals) + "' is given twice"));
      }
    };
    pairs(arguments->packages, "--package", options.import.packages);
    pairs(arguments->arguments, "--arg", options.import.arguments);
    const std::string& folder = options.import.copy_meshes;
    if (!folder.empty() && (folder.front() == '/' || folder.find("..") != std::string::npos))
      throw UsageError("--copy-meshes", Error("'" + folder + "' is not a folder beside the scene"));
    if (!options.report.empty() && !options.report.ends_with(".json") &&
        !options.report.ends_with(".html"))
      throw UsageError("--report",
                       Error("'" + options.report + "' ends neither in .json nor in .html"));
    options.import.drives = arguments->drives == "position"   ? dsl::ImportDrives::position
                            : arguments->drives == "torque"   ? dsl::ImportDrives::torque
                            : arguments->drives == "velocity" ? dsl::ImportDrives::velocity
                                                              : dsl::ImportDrives::none;
    options.import.floor = !arguments->no_floor;
    status = import_command(options);
  });
}

}  // namespace cogrsim::cli
