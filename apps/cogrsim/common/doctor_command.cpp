// cogrsim doctor: what of this installation works here, what is missing, and how to get it.
#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/core/run_program.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/loader.h"
#include "common/json_text.h"
#include "common/known_backends.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

struct Finding {
  std::string group;  ///< "engine", "program", "part", "plugin"
  std::string name;
  enum State { good, missing, broken } state = good;
  std::string detail;  ///< a version, or what is wrong
  std::string use;     ///< what it is for
  std::string remedy;  ///< empty: none is needed, or none is known
};

const char* to_string(Finding::State state) {
  constexpr const char* kNames[] = {"good", "missing", "broken"};
  return kNames[state];
}

// Folder of a plugin, or file without its ending.
std::string plugin_name(const std::string& path) {
  const std::filesystem::path file = path;
  return file.filename() == "backend.json" ? file.parent_path().filename().string()
                                           : file.stem().string();
}

// A program from packages gets its parts from there, too.
std::string how_to_get(const std::string& package, const std::string& built) {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none) == "/usr/bin/cogrsim"
             ? "sudo apt install " + package
             : built;
}

void check_plugins(const DoctorOptions& options, std::vector<Finding>& out) {
  PluginLoader loader(options.plugin_paths);
  std::vector<RefusedPlugin> refused;
  bool pictures = false;
  std::vector<std::string> found;
  for (const PluginPtr& plugin : loader.all(&refused)) {
    const PluginDescriptor& d = plugin->descriptor();
    pictures = pictures || d.kind == PluginKind::renderer;
    if (d.kind != PluginKind::backend) continue;
    const auto backend = loader.backend(d.name);
    found.push_back(d.name);
    if (backend)
      out.push_back({"engine", d.name, Finding::good, (*backend)->engine_version(), d.summary, ""});
    else
      out.push_back({"engine", d.name, Finding::broken, backend.error().message, d.summary,
                     backend.error().hint});
  }
  const auto is_engine = [](const std::string& name) {
    return std::any_of(std::begin(kKnownBackends), std::end(kKnownBackends),
                       [&](const KnownBackend& known) { return name == known.name; });
  };
  // One in another program that lacks what it needs says itself how to get it.
  for (const RefusedPlugin& each : refused) {
    const bool lacks = !each.unavailable.empty();
    const std::string name = lacks ? each.unavailable : plugin_name(each.path);
    found.push_back(name);
    out.push_back({is_engine(name) || lacks ? "engine" : "plugin", name,
                   lacks ? Finding::missing : Finding::broken, each.reason, each.path,
                   lacks ? "" : "build it against this CogRSim, or remove the file"});
  }
  for (const KnownBackend& known : kKnownBackends) {
    if (std::find(found.begin(), found.end(), known.name) != found.end()) continue;
    out.push_back(
        {"engine", known.name, Finding::missing, "not built, or not installed", "",
         how_to_get(fmt::format("cogrsim-backend-{}", known.name),
                    *known.packages ? fmt::format("sudo apt install {}, then build CogRSim again",
                                                  known.packages)
                                    : "see its README in backends/")});
  }
  out.push_back({"part", "renderer", pictures ? Finding::good : Finding::missing, "",
                 "pictures of cameras, `cogrsim render`, films",
                 pictures
                     ? ""
                     : how_to_get("cogrsim-renderer-osmesa",
                                  "sudo apt install libosmesa6-dev, then build CogRSim again")});
}

struct Program {
  std::vector<std::string> command;
  const char* use;
  const char* packages;
};

void check_programs(std::vector<Finding>& out) {
  const Program programs[] = {
      {{"gnuplot", "--version"}, "figures: `cogrsim plot`, `--plots`", "gnuplot-nox"},
      {{"ffmpeg", "-version"}, "films: `cogrsim render -o film.mp4`", "ffmpeg"},
      {{"node", "--version"}, "engines in JavaScript", "nodejs"},
      {{"c++", "--version"}, "plugins of one's own: `cogrsim new`", "g++"},
      {{"cmake", "--version"}, "plugins of one's own: `cogrsim new`", "cmake"},
      {{"mpirun", "--version"}, "sweeps over several machines", "openmpi-bin"},
      {{"python3", "--version"}, "scripts and controllers in Python", "python3"},
  };
  ProgramOptions patience;
  patience.longest = std::chrono::seconds(10);
  for (const Program& program : programs) {
    Finding finding{"program", program.command.front(), Finding::good, "", program.use, ""};
    const auto end = run_program(program.command, patience);
    if (end && end->status == 0) {
      finding.detail = end->output.substr(0, end->output.find('\n'));
    } else {
      finding.state = end ? Finding::broken : Finding::missing;
      finding.detail =
          end ? fmt::format("exit status {}: {}", end->status, end->output) : end.error().message();
      finding.remedy = fmt::format("sudo apt install {}", program.packages);
    }
    out.push_back(finding);
  }
}

void check_parts(const DoctorOptions& options, std::vector<Finding>& out) {
  void* const mpi = dlopen("libcogrsim_mpi.so", RTLD_NOW | RTLD_LOCAL);
  out.push_back({"part", "MPI", mpi ? Finding::good : Finding::missing, "",
                 "sweeps over several machines",
                 mpi ? ""
                     : how_to_get("cogrsim-mpi",
                                  "sudo apt install libopenmpi-dev, then build CogRSim again")});
  out.push_back({"part", "studio", options.has_studio ? Finding::good : Finding::missing, "",
                 "`cogrsim studio`, `cogrsim bundle`",
                 options.has_studio ? ""
                                    : how_to_get("cogrsim-studio",
                                                 "build CogRSim where npm reaches its registry")});
  ProgramOptions patience;
  patience.longest = std::chrono::seconds(20);
  const auto module =
      run_program({"python3", "-c", "import cogrsim; print(cogrsim.__file__)"}, patience);
  const bool has_module = module && module->status == 0;
  out.push_back({"part", "Python module", has_module ? Finding::good : Finding::missing,
                 has_module ? module->output.substr(0, module->output.find('\n')) : "",
                 "`import cogrsim`",
                 has_module ? ""
                            : "install python3-cogrsim, or set PYTHONPATH to CogRSim's "
                              "lib/python3/dist-packages"});
}

std::string text_of(const std::vector<Finding>& findings, const Style& style) {
  std::string out, group;
  std::size_t missing = 0, broken = 0;
  for (const Finding& each : findings) {
    if (each.group != group) {
      group = each.group;
      out += fmt::format("{}{}{}s{}\n", out.empty() ? "" : "\n", style.bold, group, style.off);
    }
    missing += each.state == Finding::missing;
    broken += each.state == Finding::broken;
    const std::string& color = each.state == Finding::good      ? style.green
                               : each.state == Finding::missing ? style.yellow
                                                                : style.red;
    out +=
        fmt::format("  {}{:<8}{} {:<14} {}\n", color, to_string(each.state), style.off,
                    one_line(each.name), paragraph(each.detail.empty() ? each.use : each.detail));
    if (each.state == Finding::good) continue;
    if (!each.detail.empty() && !each.use.empty())
      out += fmt::format("           {:<14} for: {}\n", "", one_line(each.use));
    if (!each.remedy.empty()) out += fmt::format("           {:<14} help: {}\n", "", each.remedy);
  }
  return out + fmt::format("\n{} missing, {} broken\n", missing, broken);
}

Json json_of(const std::vector<Finding>& findings) {
  Json out = Json::array();
  for (const Finding& each : findings)
    out.push_back({{"group", each.group},
                   {"name", each.name},
                   {"state", to_string(each.state)},
                   {"detail", each.detail},
                   {"use", each.use},
                   {"remedy", each.remedy.empty() ? Json(nullptr) : Json(each.remedy)}});
  return {{"findings", std::move(out)}};
}

}  // namespace

int doctor_command(const DoctorOptions& options) {
  std::vector<Finding> findings;
  check_plugins(options, findings);
  check_programs(findings);
  check_parts(options, findings);
  const char* const kOrder[] = {"engine", "part", "program", "plugin"};
  const auto place = [&](const Finding& each) {
    return std::find(std::begin(kOrder), std::end(kOrder), each.group) - std::begin(kOrder);
  };
  std::stable_sort(findings.begin(), findings.end(), [&](const Finding& a, const Finding& b) {
    return place(a) != place(b) ? place(a) < place(b) : a.group == "engine" && a.name < b.name;
  });
  const auto printed =
      print_found(options.json, [&] { return json_text(json_of(findings)); },
                  [&] { return text_of(findings, style_of(fileno(standard_output()))); });
  if (!printed) return refuse(printed.error());
  const auto is = [&](const char* group, Finding::State state) {
    return std::any_of(findings.begin(), findings.end(), [&](const Finding& each) {
      return each.state == state && (!*group || each.group == group);
    });
  };
  return is("", Finding::broken) || !is("engine", Finding::good) ? kFailed : kGood;
}

}  // namespace cogrsim::cli
