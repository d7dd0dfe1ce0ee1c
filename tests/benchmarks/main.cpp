// Engines side by side. See --help, and README.md here.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "measure.h"
#include "report.h"
#include "studies.h"

namespace {

using namespace cogrsim::bench;

/// Of the table, in its order.
const std::vector<std::string> kTable = {"spheres", "pyramid", "falling-boxes",  "chain",
                                         "stack",   "robots",  "robots-infrared"};
/// What is measured otherwise.
const std::vector<std::string> kStudies = {"precision", "growth-boxes", "growth-robots", "compile",
                                           "rays",      "cameras",      "allocations"};

struct Options {
  std::vector<std::string> scenes, engines;
  bool quick = false, allocations = false, list = false;
  int rounds = 0;
  double limit = 0;
  std::string json, markdown, pictures;
};

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// One line on a terminal that is written over again and again; nothing elsewhere but a line now
/// and then would be of use, so nothing.
void show(const std::string& text) {
  static const bool terminal = isatty(2) != 0;
  if (terminal) fmt::print(stderr, "\r\033[K{}", text);
}

class Benchmark {
 public:
  Benchmark(const Options& options, const std::string& folder)
      : options_(options), folder_(folder), engines_(find_engines(folder)) {
    effort_.rounds = options.rounds > 0 ? options.rounds : options.quick ? 3 : 9;
    effort_.limit = options.limit > 0 ? options.limit : options.quick ? 6.0 : 20.0;
    results_.quick = options.quick;
  }

  const std::vector<Engine>& engines() const { return engines_; }

  Results run() {
    results_.machine = this_machine(COGRSIM_SOURCE_DIR);
    if (options_.allocations) {
      count_allocations_of(
          {"spheres", "pyramid", "falling-boxes", "chain", "robots", "robots-infrared", "grid"}, 5);
      return results_;
    }
    for (const std::string& scene : kTable) {
      if (!wanted(scene)) continue;
      const int count = options_.quick && scene == "falling-boxes" ? 300 : 0;
      const std::vector<Row> rows = measure(chosen(scene == "stack"), scene, count, effort_, show);
      show("");
      print_scene(rows);
      std::fflush(stdout);
      results_.table.insert(results_.table.end(), rows.begin(), rows.end());
    }
    if (wanted("precision")) {
      results_.precision = measure_precision(chosen(false), options_.quick, show);
    }
    if (wanted("growth-boxes")) {
      grow("grid",
           options_.quick ? std::vector<int>{10, 100, 1000}
                          : std::vector<int>{10, 30, 100, 300, 1000, 3000, 10000},
           results_.growth_boxes);
    }
    if (wanted("growth-robots")) {
      grow("robots",
           options_.quick ? std::vector<int>{1, 10, 100} : std::vector<int>{1, 10, 100, 1000},
           results_.growth_robots);
    }
    if (wanted("compile")) {
      results_.compiling = measure_compiling(folder_, options_.quick, show);
    }
    if (wanted("rays")) measure_rays();
    if (wanted("cameras")) measure_cameras();
    if (wanted("allocations")) {
      count_allocations_of(options_.quick
                               ? std::vector<std::string>{"chain", "robots-infrared"}
                               : std::vector<std::string>{"spheres", "pyramid", "falling-boxes",
                                                          "chain", "robots", "robots-infrared"},
                           0);
    }
    show("");
    print_rest(results_);
    return results_;
  }

 private:
  bool wanted(const std::string& scene) const {
    return options_.scenes.empty() || contains(options_.scenes, scene);
  }
  std::vector<Engine> chosen(bool with_mesh) const {
    std::vector<Engine> out;
    for (const Engine& engine : engines_) {
      if (!options_.engines.empty() && !contains(options_.engines, engine.name)) continue;
      if (engine.name == "raw-simbody-mesh" && !with_mesh) continue;
      out.push_back(engine);
    }
    return out;
  }

  /// Our backends beside their bare engines; who is given up is not asked again for more.
  void grow(const std::string& scene, const std::vector<int>& counts, std::vector<Row>& out) {
    std::vector<Engine> engines;
    for (const Engine& engine : chosen(false)) {
      const bool ours = engine.name.rfind("cogrsim-", 0) == 0;
      const bool bare = std::any_of(engines_.begin(), engines_.end(), [&](const Engine& other) {
        return other.raw == engine.name && other.name.rfind("cogrsim-", 0) == 0;
      });
      if (ours || bare) engines.push_back(engine);
    }
    for (const int count : counts) {
      Effort effort = effort_;
      effort.rounds = std::min(effort.rounds, 5);
      std::vector<Row> rows = measure(engines, scene, count, effort, show);
      show("");
      print_scene(rows);
      for (const Row& row : rows) {
        if (row.missing.empty()) continue;
        engines.erase(std::remove_if(engines.begin(), engines.end(),
                                     [&](const Engine& e) { return e.name == row.engine; }),
                      engines.end());
      }
      out.insert(out.end(), rows.begin(), rows.end());
    }
  }

  void count_allocations_of(const std::vector<std::string>& scenes, int sites) {
    results_.allocations = count_allocations(chosen(false), scenes, options_.quick, show);
    show("");
    print_allocations(results_.allocations, sites);
  }

  void measure_rays() {
    show("rays");
    results_.rays =
        measure_apart(folder_ + "/cogrsim_ray_benchmark", {options_.quick ? "5" : "21", "--json"},
                      "libbullet-dev", 60, results_.rays_missing);
  }
  void measure_cameras() {
    show("cameras");
    results_.cameras = measure_apart(folder_ + "/cogrsim_camera_bench",
                                     {"--json", "--width", options_.quick ? "160" : "320",
                                      "--rounds", options_.quick ? "2" : "5"},
                                     "libmujoco-dev", 120, results_.cameras_missing);
  }

  Options options_;
  std::string folder_;
  std::vector<Engine> engines_;
  Effort effort_;
  Results results_;
};

/// Errors name what there is.
void check_names(const std::string& what, const std::vector<std::string>& given,
                 const std::vector<std::string>& known) {
  for (const std::string& name : given) {
    if (!contains(known, name)) {
      throw std::invalid_argument(
          fmt::format("there is no {} '{}'; there are {}", what, name, joined(known)));
    }
  }
}

void check_writable(const std::string& path) {
  if (path.empty()) return;
  std::ofstream file(path, std::ios::app);
  if (!file) throw std::invalid_argument(fmt::format("cannot write '{}'", path));
}

int run(const Options& options, const std::string& folder) {
  Benchmark benchmark(options, folder);
  std::vector<std::string> engines, scenes = kTable;
  scenes.insert(scenes.end(), kStudies.begin(), kStudies.end());
  for (const Engine& engine : benchmark.engines()) engines.push_back(engine.name);
  if (options.list) {
    fmt::print("scenes: {}\nengines:\n", joined(scenes));
    for (const Engine& engine : benchmark.engines()) {
      fmt::print("  {:<18} {}\n", engine.name,
                 engine.command.empty() ? "not installed: " + engine.package : "");
    }
    return 0;
  }
  check_names("engine", options.engines, engines);
  check_names("scene", options.scenes, scenes);
  // Not after ten minutes.
  check_writable(options.json);
  check_writable(options.markdown);
  const Results results = benchmark.run();
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    file << to_json(results).dump(2) << "\n";
    file.close();
    if (!file) throw std::runtime_error(fmt::format("cannot write '{}'", options.json));
  }
  if (!options.markdown.empty()) {
    const std::string pictures =
        options.pictures.empty()
            ? (std::filesystem::absolute(options.markdown).parent_path() / "pictures").string()
            : options.pictures;
    write_markdown(results, options.markdown, pictures);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Measures CogRSim's backends beside programs on the bare engines and on their peers.\n\n"
      "  scripts/benchmark                                  all of it, some ten minutes\n"
      "  scripts/benchmark --quick                          the same in short, below two minutes\n"
      "  scripts/benchmark --scene pyramid --scene chain    two scenes of the table\n"
      "  scripts/benchmark --engine raw-ode --engine mujoco --rounds 21\n"
      "  scripts/benchmark --json build/benchmarks.json --markdown docs/dev/benchmarks.md\n"
      "  scripts/benchmark --allocations                    who allocates in a step, and from "
      "where\n",
      "scripts/benchmark"};
  app.add_option("--scene", options.scenes, "only these; --list names them")->type_name("NAME");
  app.add_option("--engine", options.engines, "only these in the tables; --list names them")
      ->type_name("NAME");
  app.add_flag("--quick", options.quick, "fewer rounds and smaller numbers");
  app.add_option("--rounds", options.rounds, "rounds for each engine and scene")
      ->check(CLI::Range(1, 10000))
      ->type_name("N");
  app.add_option("--limit", options.limit, "seconds that one engine may need for one scene")
      ->check(CLI::Range(0.1, 1e5))
      ->type_name("S");
  app.add_option("--json", options.json, "write an array, one object per engine and scene")
      ->type_name("FILE");
  app.add_option("--markdown", options.markdown, "write a page with tables and pictures")
      ->type_name("FILE");
  app.add_option("--pictures", options.pictures, "folder for its pictures; else beside the page")
      ->type_name("FOLDER");
  app.add_flag("--allocations", options.allocations,
               "count calls of the allocator only, and say where they come from");
  app.add_flag("--list", options.list, "name scenes and engines");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const std::string self = std::filesystem::canonical("/proc/self/exe").string();
    return run(options, self.substr(0, self.rfind('/')));
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
