#include "import/import_command.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/geometry/overlap.h"
#include "cogrsim/simulation/simulation.h"
#include "common/arguments.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "import/fidelity_report.h"

namespace cogrsim::cli {

namespace fs = std::filesystem;

namespace {

struct ImportCommandOptions {
  std::string file, output, report;
  bool strict = false;
  dsl::ImportOptions import;
};

using Loader = std::shared_ptr<PluginLoader>;

/// Why an engine does not run a scene; empty: it does.
std::vector<std::string> reasons_against(const std::string& engine, const SceneModelPtr& model,
                                         const Loader& loader) {
  SimulationOptions options;
  options.backend = engine;
  std::vector<std::string> out;
  if (const auto simulation = Simulation::create(model, options, loader); !simulation)
    for (const Diagnostic& d : simulation.error())
      if (d.severity == Severity::error) out.push_back(d.message);
  return out;
}

/// What reasons_against() says, by a process of its own, as engines cannot be interrupted. Takes the
/// processor time from `seconds`; empty: it was not enough.
std::string tried(const std::string& engine, const SceneModelPtr& model, const Loader& loader,
                  double& seconds) {
  if (seconds <= 0.0) return {};
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) return "could not be tried";
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    itimerval timer{};
    timer.it_value.tv_sec = static_cast<time_t>(seconds);
    timer.it_value.tv_usec = 1 + static_cast<suseconds_t>(999'998.0 * std::fmod(seconds, 1.0));
    ::setitimer(ITIMER_PROF, &timer, nullptr);  // of processor time: SIGPROF ends this process
    const std::vector<std::string> reasons = reasons_against(engine, model, loader);
    std::string verdict = "runs it";
    if (!reasons.empty()) verdict = "does not run it: " + reasons.front();
    if (reasons.size() > 1) verdict += fmt::format(", and {} more", reasons.size() - 1);
    verdict.resize(std::min<std::size_t>(verdict.size(), PIPE_BUF));
    ::_exit(::write(ends[1], verdict.data(), verdict.size()) < 0 ? 1 : 0);
  }
  ::close(ends[1]);
  std::string verdict(PIPE_BUF, '\0');
  const ssize_t size = child < 0 ? 0 : ::read(ends[0], verdict.data(), verdict.size());
  ::close(ends[0]);
  if (child < 0) return "could not be tried";
  int status = 0;
  rusage used{};
  ::wait4(child, &status, 0, &used);
  for (const timeval& t : {used.ru_utime, used.ru_stime})
    seconds -= static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF) return {};
  if (size <= 0) return "does not run it: it ends the program";
  verdict.resize(static_cast<std::size_t>(size));
  return verdict;
}

/// Which installed engines run the scene, and the first reason of each that does not.
void print_engines(const SceneModelPtr& model, const Loader& loader) {
  // Some engines take minutes to add many bodies; large meshes may take longer.
  double seconds = 2.0;
  for (const MeshPtr& mesh : model->meshes)
    seconds += 1e-5 * static_cast<double>(mesh->triangles.size());
  bool all = true;
  for (const std::string& name : library_backends(loader)) {
    std::string verdict = tried(name, model, loader, seconds);
    if (verdict.empty()) verdict = "was not tried to the end, which takes long: cogrsim run does";
    all = all && verdict == "runs it";
    std::fputs(fmt::format("  {:<10}{}\n", one_line(name), one_line(verdict)).c_str(), stderr);
  }
  if (!all) std::fputs("  --without lacking leaves out of a run what its engine lacks\n", stderr);
}

/// Links of one robot that start inside each other, as convex hulls often do, would be thrown apart:
/// they get no contact, which the report says. Whether there are any.
bool part_overlapping_links(const SceneModel& model, dsl::ImportResult& result) {
  std::vector<int> parent(model.bodies.size(), kWorld);
  for (const Joint& joint : model.joints) {
    int& of_child = parent[joint.child];
    if (joint.closes_loop || of_child != kWorld) continue;
    of_child = joint.parent;
  }
  const auto root = [&](int body) {
    while (parent[body] != kWorld) body = parent[body];
    return body;
  };
  const std::size_t prototype = result.scene.rfind("  </prototype>");
  if (prototype == std::string::npos) return false;
  // Rules that follow the prototype would overrule its own.
  const bool in_scene = result.scene.find("\n  <collide ", prototype) != std::string::npos;
  const std::size_t at = in_scene ? result.scene.rfind("</scene>") : prototype;
  std::string pairs;
  for (const geometry::Overlap& o : geometry::find_overlaps(model).pairs) {
    if (root(o.body_a) != root(o.body_b)) continue;
    const std::string& full_a = model.bodies[o.body_a].name;
    const std::string& full_b = model.bodies[o.body_b].name;
    const std::string a = full_a.substr(full_a.find('.') + 1);
    const std::string b = full_b.substr(full_b.find('.') + 1);
    pairs += fmt::format("{}<collide between=\"{} {}\" with=\"false\"/>\n",
                         in_scene ? "  " : "    ", in_scene ? full_a : a, in_scene ? full_b : b);
    dsl::ImportEntry entry;
    entry.fidelity = dsl::Fidelity::approximate;
    entry.element = fmt::format("links '{}' and '{}'", a, b);
    entry.message =
        fmt::format("start {:.3g} mm inside each other: they do not collide", o.depth * 1e3);
    result.entries.push_back(std::move(entry));
  }
  if (pairs.empty()) return false;
  result.scene.insert(at, pairs);
  return true;
}

int import_command(const ImportCommandOptions& options) {
  add_input(options.file);
  const std::vector<std::pair<std::string, OutputKind>> outputs = {
      {options.output, OutputKind::xml}, {options.report, report_kind(options.report)}};
  if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
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
  const auto loader = std::make_shared<PluginLoader>();
  dsl::LoaderCatalog catalog(loader);
  import.plugins = &catalog;
  StatusLine progress;
  import.decomposing = [&](const std::string& mesh) {
    if (progress.shown()) progress.show("import: decomposing " + one_line(mesh));
  };
  dsl::ImportResult result = dsl::import_model(options.file, import);
  progress.clear();
  for (const std::string& read : result.files_read) add_input(read);
  // Now that all inputs are known, and before anything is written.
  if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
  print_diagnostics(result.diagnostics);
  const auto report = [&] {
    print_fidelity(result);
    const ConversionTitle title{"Import of " + options.file, options.file, result.format,
                                !result.scene.empty()};
    return write_fidelity(options.report, title, result, result.diagnostics);
  };
  const std::size_t lost = result.count(dsl::Fidelity::left_out);
  if (result.scene.empty() || (options.strict && lost > 0)) {
    if (const auto written = report(); !written) return refuse(written.error());
    print_error(result.scene.empty()
                    ? fmt::format("'{}' could not be imported", options.file)
                    : fmt::format("{} left out, and --strict allows none; nothing was written",
                                  count_text(lost, "element was", "elements were")));
    return kFailed;
  }
  if (const auto written = dsl::write_beside(import.scene_folder, result.files, output_rules());
      !written)
    return refuse(written.error());
  dsl::CompileOptions compile;
  compile.plugins = &catalog;
  const auto compiled = [&] { return dsl::compile_text(result.scene, output.string(), compile); };
  dsl::CompileResult scene = compiled();
  if (scene.ok() && part_overlapping_links(*scene.model, result)) scene = compiled();
  if (const auto written = report(); !written) return refuse(written.error());
  if (options.output.empty() || options.output == "-") {
    const auto printed = print_output(result.scene);
    return printed ? kGood : refuse(printed.error());
  }
  if (const auto written = write_output(options.output, OutputKind::xml, result.scene); !written)
    return refuse(written.error());
  // What was written is a scene, or that is our mistake: say so at once.
  std::vector<Diagnostic> errors;
  for (const Diagnostic& d : scene.diagnostics)
    if (d.severity == Severity::error) errors.push_back(d);
  print_diagnostics(errors);
  if (!scene.ok()) {
    print_error(fmt::format("'{}' was written, and is not a valid scene", options.output));
    return kFailed;
  }
  std::fputs(fmt::format("{}: {}; {} exact, {} approximate, {} left out\n",
                         one_line(options.output),
                         count_text(scene.model->bodies.size(), "body", "bodies") + ", " +
                             count_text(scene.model->joints.size(), "joint", "joints"),
                         result.count(dsl::Fidelity::exact),
                         result.count(dsl::Fidelity::approximate), lost)
                 .c_str(),
             stderr);
  print_engines(scene.model, loader);
  return kGood;
}

}  // namespace

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
  command
      .add_option("--keyframe", o.import.keyframe,
                  "Keyframe of an MJCF in which the robot starts; default: at its zero")
      ->type_name("NAME");
  command.add_flag("--fixed-base", o.import.fixed_base, "The root link is static");
  command.add_flag("--no-floor", arguments->no_floor, "Add no floor below the robot");
  command
      .add_option("--copy-meshes", o.import.copy_meshes,
                  "Copy all meshes into this folder beside the scene; default: only those that the "
                  "scene cannot refer to, into meshes")
      ->type_name("DIR");
  command
      .add_option("--convex-parts", o.import.convex_parts,
                  "Decompose moving meshes of URDF and SDF into at most N convex parts for "
                  "collisions; default: their hull")
      ->check(CLI::Range(1, 64))
      ->type_name("N");
  add_report_options(command, o.report, o.strict);
  command.footer(
      "Examples:\n"
      "  cogrsim import robot.urdf -o robot.scene.xml\n"
      "  cogrsim import arm.urdf.xacro -o arm.scene.xml --package "
      "arm_description=../arm_description\n"
      "  cogrsim import humanoid.xml -o humanoid.scene.xml --report humanoid.html\n"
      "  cogrsim import gripper.urdf -o gripper.scene.xml --convex-parts 8\n"
      "Then: cogrsim run robot.scene.xml, or cogrsim studio robot.scene.xml.\n"
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
    check_report_name(options.report);
    options.import.drives = arguments->drives == "position"   ? dsl::ImportDrives::position
                            : arguments->drives == "torque"   ? dsl::ImportDrives::torque
                            : arguments->drives == "velocity" ? dsl::ImportDrives::velocity
                                                              : dsl::ImportDrives::none;
    options.import.floor = !arguments->no_floor;
    status = import_command(options);
  });
}

}  // namespace cogrsim::cli
