// docs/dev/benchmarks.md, from a run.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "cogrsim/figures/draw.h"
#include "report.h"

namespace cogrsim::bench {

namespace {

using Json = nlohmann::json;

/// Draws; keeps the picture and not what it was made from, which is in the JSON of the run.
void draw_picture(figures::Figure figure, const std::string& path) {
  figures::DrawOptions options;
  options.width = 900;
  options.height = 560;
  const auto drawn = figures::draw(std::move(figure), path, options);
  if (!drawn) throw std::runtime_error(drawn.error().text());
  for (std::size_t i = 1; i < drawn->size(); ++i) std::filesystem::remove((*drawn)[i]);
}

void draw_precision(const std::vector<PrecisionPoint>& points, const std::string& path) {
  figures::Figure figure;
  figure.title = "Tumbling box: what accuracy costs";
  figure.x = {"processor time for a simulated second", "us", true};
  figure.y = {fmt::format("error of the orientation after {:g} s", kPrecisionTime), "rad", true};
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> lines;
  for (const PrecisionPoint& point : points) {
    if (!point.missing.empty()) continue;
    lines[point.engine].first.push_back(point.cost);
    lines[point.engine].second.push_back(std::max(point.error, 1e-16));
  }
  for (auto& [engine, line] : lines) {
    figures::add_series(figure, line.first, line.second, engine);
  }
  draw_picture(std::move(figure), path);
}

void draw_growth(const std::vector<Row>& rows, const std::string& title, const std::string& what,
                 const std::string& path) {
  figures::Figure figure;
  figure.title = title;
  figure.x = {what, "", true};
  figure.y = {"processor time for a step", "us", true};
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> lines;
  for (const Row& row : rows) {
    if (!row.missing.empty()) continue;
    lines[row.engine].first.push_back(row.bodies);
    lines[row.engine].second.push_back(row.time.median);
  }
  for (auto& [engine, line] : lines) {
    figures::add_series(figure, line.first, line.second, engine);
  }
  draw_picture(std::move(figure), path);
}

std::string microseconds(double value) {
  return value < 100 ? fmt::format("{:.1f}", value) : fmt::format("{:.0f}", value);
}

std::string machine_part(const Results& results) {
  const Machine& m = results.machine;
  std::map<std::string, std::string> versions;
  for (const Row& row : results.table) {
    if (!row.version.empty()) versions[row.engine] = row.version;
  }
  std::string list;
  for (const auto& [engine, version] : versions) {
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", engine, version);
  }
  return fmt::format(
      "| | |\n|---|---|\n| processor | {}, {} cores, {:.0f} GB |\n| system | {} |\n"
      "| compiler | {}, preset `release` (-O2) |\n| engines | {} |\n| date | {} |\n| commit | {} "
      "|\n"
      "| rounds | {} |\n",
      m.cpu, m.cores, m.memory / 1e9, m.system, m.compiler, list, m.date,
      m.commit.empty() ? "not a git checkout" : m.commit,
      results.quick ? "few (`--quick`)" : "as many as usual");
}

std::string table_part(const std::vector<Row>& rows) {
  std::string out, scene;
  for (const Row& row : rows) {
    if (row.scene != scene) {
      scene = row.scene;
      out += fmt::format("\n### {}\n\nCheck: {}.\n\n", row.title, row.check_text);
      out += "| engine | us/step | quartiles | ratio | quartiles | check | |\n";
      out += "|---|---:|---:|---:|---:|---:|---|\n";
    }
    if (!row.missing.empty()) {
      out += fmt::format("| {} | – | – | – | – | – | {} |\n", row.engine, row.missing);
      continue;
    }
    out += fmt::format("| {} | {} | {} to {} | ", row.engine, microseconds(row.time.median),
                       microseconds(row.time.low), microseconds(row.time.high));
    out += row.ratio ? fmt::format("{:.2f} | {:.2f} to {:.2f}", row.ratio->median, row.ratio->low,
                                   row.ratio->high)
                     : std::string(" | ");
    out += fmt::format(" | {:.5g} | {} |\n", row.check, row.note);
  }
  return out;
}

std::string growth_part(const std::vector<Row>& rows, int from) {
  std::vector<std::string> engines;
  std::vector<int> counts;
  for (const Row& row : rows) {
    if (std::find(engines.begin(), engines.end(), row.engine) == engines.end()) {
      engines.push_back(row.engine);
    }
    if (row.bodies > 0 && std::find(counts.begin(), counts.end(), row.bodies) == counts.end()) {
      counts.push_back(row.bodies);
    }
  }
  std::string out = "\n| engine |", rule = "|---|";
  for (const int count : counts) {
    out += fmt::format(" {} |", count);
    rule += "---:|";
  }
  out += " power |\n" + rule + "---:|\n";
  for (const std::string& engine : engines) {
    out += fmt::format("| {} |", engine);
    for (const int count : counts) {
      std::string cell = "–";
      for (const Row& row : rows) {
        if (row.engine == engine && row.bodies == count && row.missing.empty()) {
          cell = microseconds(row.time.median);
        }
      }
      out += fmt::format(" {} |", cell);
    }
    const double power = growth_exponent(rows, engine, from);
    out += std::isfinite(power) ? fmt::format(" {:.2f} |\n", power) : " – |\n";
  }
  return out;
}

std::string memory_part(const std::vector<Row>& rows) {
  std::map<std::string, std::pair<const Row*, const Row*>> ends;
  for (const Row& row : rows) {
    if (!row.missing.empty()) continue;
    auto& [first, last] = ends[row.engine];
    if (!first || row.bodies < first->bodies) first = &row;
    if (!last || row.bodies > last->bodies) last = &row;
  }
  std::string out = "\n| engine | bodies | kB per body |\n|---|---:|---:|\n";
  for (const auto& [engine, pair] : ends) {
    const auto& [first, last] = pair;
    if (last->bodies <= first->bodies) continue;
    out += fmt::format("| {} | {} | {:.1f} |\n", engine, last->bodies,
                       (last->memory - first->memory) / (last->bodies - first->bodies) / 1e3);
  }
  return out;
}

std::string allocation_part(const std::vector<AllocationRow>& rows) {
  std::string out = "\n| engine | scene | layer | ours per step | engine's per step |\n";
  out += "|---|---|---|---:|---:|\n";
  for (const AllocationRow& row : rows) {
    if (row.missing.empty()) {
      out += fmt::format("| {} | {} | {} | {:.2f} | {:.2f} |\n", row.engine, row.scene, row.layer,
                         row.ours, row.engines);
    } else {
      out += fmt::format("| {} | {} | – | – | {} |\n", row.engine, row.scene, row.missing);
    }
  }
  return out;
}

std::string rays_part(const Results& results) {
  if (!results.rays.is_array()) return results.rays_missing + "\n";
  std::string out =
      "| caster | million rays/s | wrong by 1 um | wrong by 1 mm | largest error [m] |\n"
      "|---|---:|---:|---:|---:|\n";
  for (const Json& row : results.rays) {
    out += fmt::format("| {} | {:.2f} | {} | {} | {:.2g} |\n", row.at("engine").get<std::string>(),
                       row.at("rays_per_s").get<double>() / 1e6, row.at("wrong_by_1_um").get<int>(),
                       row.at("wrong_by_1_mm").get<int>(), row.at("largest_error_m").get<double>());
  }
  const Json& ours = results.rays.front();
  return out + fmt::format(
                   "\nRatio of neighbouring rounds, median: {:.1f}. Moving all bodies costs "
                   "{:.0f} us before the next ray.\n",
                   ours.at("ratio_to_raw_bullet").get<double>(),
                   ours.at("moving_all_us").get<double>());
}

std::string cameras_part(const Results& results) {
  if (!results.cameras.is_array()) return results.cameras_missing + "\n";
  std::string out =
      "| size | shapes | shadows | samples | ours [1/s] | MuJoCo [1/s] | ratio |\n"
      "|---|---:|---|---:|---:|---:|---:|\n";
  for (const Json& row : results.cameras) {
    out += fmt::format("| {} x {} | {} | {} | {} | {:.1f} | {:.1f} | {:.2f} |\n",
                       row.at("width").get<int>(), row.at("height").get<int>(),
                       row.at("shapes").get<int>(), row.at("shadows").get<bool>() ? "yes" : "no",
                       row.at("samples").get<int>(), row.at("frames_per_second").get<double>(),
                       row.at("mujoco_frames_per_second").get<double>(),
                       row.at("ratio").get<double>());
  }
  return out;
}

std::string claims_part(const Results& results) {
  std::string out = "| aim | measured | |\n|---|---|---|\n";
  for (const Claim& claim : claims_of(results)) {
    const char* state = claim.state == Claim::reached  ? "reached"
                        : claim.state == Claim::missed ? "**not reached**"
                                                       : "";
    out += fmt::format("| {} | {} | {} |\n", claim.what, claim.measured, state);
  }
  return out;
}

std::string settings_part(const std::vector<Row>& rows) {
  std::map<std::string, std::string> settings;
  for (const Row& row : rows) {
    if (!row.settings.empty()) settings[row.engine] = row.settings;
  }
  std::string out = "| engine | settings |\n|---|---|\n";
  for (const auto& [engine, text] : settings) out += fmt::format("| {} | {} |\n", engine, text);
  return out;
}

std::string scenes_part() {
  std::string out = "| scene | | expected value | within |\n|---|---|---|---|\n";
  for (const SceneInfo& info : scene_list()) {
    const Scene scene = make_scene(info.name);
    if (scene.name == "tumbling" || scene.name == "grid") continue;
    out += fmt::format("| {} | {} | {}: {} | {:g} % |\n", info.name, info.what, scene.check_text,
                       scene.why_expected, scene.within * 100);
  }
  return out;
}

}  // namespace

void write_markdown(const Results& results, const std::string& path, const std::string& pictures) {
  std::filesystem::create_directories(pictures);
  const std::filesystem::path page = std::filesystem::absolute(path);
  const auto link = [&](const char* name) {
    return std::filesystem::relative(std::filesystem::absolute(pictures) / name, page.parent_path())
        .generic_string();
  };
  std::string out =
      "# Benchmarks\n\n"
      "Written by `./scripts/benchmark --json build/benchmarks.json --markdown "
      "docs/dev/benchmarks.md`: "
      "do not edit. The\nprograms are in [tests/benchmarks](../../tests/benchmarks/), one for each "
      "engine.\n\n";
  out += machine_part(results);
  out += "\n## Aims\n\n" + claims_part(results);
  out +=
      "\n## How it is measured\n\n"
      "Each engine has a program that builds the same scene as the engine's manual recommends and "
      "makes the same steps.\nEach program of a scene is a process; after a warm-up they run in "
      "rounds, one at a time. The tables have the\nmedians over the rounds and the quartiles of the "
      "processor time of all threads. A ratio is that of neighbouring rounds, so\nthat other load "
      "affects both. `cogrsim-X` is our backend X, its ratio is to `raw-X`; that of "
      "`ignition-bullet` is to\n`raw-bullet`, that of `raw-simbody-mesh` to `cogrsim-cogrsim`. If "
      "an engine does not support a scene, the reason is given.\n\n"
      "To ensure that all engines do the same work, a value is compared after the warm-up:\n\n" +
      scenes_part() +
      "\nIf a row says that an engine does something else, its time is not comparable. Sleeping is "
      "disabled.\n\n" +
      settings_part(results.table);
  out += "\n## Scenes\n" + table_part(results.table);
  if (!results.precision.empty()) {
    draw_precision(results.precision, pictures + "/bench-precision.svg");
    out += fmt::format(
        "\n## What accuracy costs\n\nA box of 0.2 x 0.4 x 0.6 m tumbles freely, spin (1, 3, 1) "
        "rad/s. The orientation after {:g} s is compared with\nEuler's equations solved by the "
        "Runge-Kutta method in extended precision with steps of 20 us; each point is a step size "
        "from\n32 ms to 0.25 ms. Lower left is better.\n\n![error over cost]({})\n",
        kPrecisionTime, link("bench-precision.svg"));
    for (const PrecisionPoint& point : results.precision) {
      if (!point.missing.empty()) {
        out += fmt::format("\nNot measured: {}, {}.\n", point.engine, point.missing);
      }
    }
  }
  if (!results.growth_boxes.empty()) {
    draw_growth(results.growth_boxes, "Boxes on a floor", "boxes",
                pictures + "/bench-growth-boxes.svg");
    out += fmt::format(
        "\n## Growth\n\nBoxes that lie on a floor, four contact points each, us/step by their "
        "number. Power: the time grows as the number to that\npower, fitted from 100 boxes up; 1 "
        "is linear.\n\n![boxes]({})\n{}",
        link("bench-growth-boxes.svg"), growth_part(results.growth_boxes, 100));
  }
  if (!results.growth_robots.empty()) {
    draw_growth(results.growth_robots, "Two-wheel robots", "bodies, three a robot",
                pictures + "/bench-growth-robots.svg");
    out += fmt::format(
        "\nRobots on two wheels, 1 to 1000 of three bodies each, by the number of bodies:\n\n"
        "![robots]({})\n{}",
        link("bench-growth-robots.svg"), growth_part(results.growth_robots, 30));
  }
  if (!results.growth_boxes.empty()) {
    out +=
        "\n### Memory\n\nResident memory of the process that simulates the boxes above, after "
        "the warm-up, less that before the scene was built;\nper body between the smallest and "
        "the largest number.\n" +
        memory_part(results.growth_boxes);
  }
  if (!results.compiling.empty()) {
    out +=
        "\n### Compiling scenes\n\nA scene file of boxes, every tenth on a hinge.\n\n"
        "| bodies | kB | ms | us per body |\n|---:|---:|---:|---:|\n";
    for (const CompilePoint& point : results.compiling) {
      out += fmt::format("| {} | {:.0f} | {:.2f} | {:.1f} |\n", point.bodies, point.bytes / 1e3,
                         point.time.median / 1e3, point.time.median / point.bodies);
    }
  }
  if (!results.allocations.empty()) {
    out +=
        "\n## Allocations\n\nCalls of the allocator in a step after warm-up, counted by one "
        "that stands in for it. *World* is the backend with state\nand contacts read in each "
        "step, *simulation* a run with an observer that wants contacts. Ours is what was "
        "called from\nlibcogrsim, a plugin or a backend, engines' own calls are beside it. "
        "`./scripts/benchmark --allocations` says where.\n" +
        allocation_part(results.allocations);
  }
  if (results.rays.is_array() || !results.rays_missing.empty()) {
    out +=
        "\n## Rays\n\n1000 rays at 1000 boxes, spheres, cylinders and capsules, judged by a slow "
        "reference in extended precision.\n\n" +
        rays_part(results);
  }
  if (results.cameras.is_array() || !results.cameras_missing.empty()) {
    out +=
        "\n## Pictures\n\nThe same scene drawn by our renderer and by MuJoCo's own, both on "
        "OSMesa.\n\n" +
        cameras_part(results);
  }
  out +=
      "\n## The JSON\n\n`--json FILE` writes an array with an object for each engine and scene. "
      "Keys: `engine`, `version`, `scene`, `title`,\n`bodies`, `dt` [s], `rounds`, `steps` (in a "
      "round), `us_per_step` (median), `us_per_step_quartiles`, `ratio_to`, `ratio`,\n"
      "`ratio_quartiles`, `check` (`what`, `value`, `expected`, `within`, `agrees`), `build_us`, "
      "`memory_bytes`, `settings`, `note`;\nor `missing`, the reason why there are no figures. "
      "Scenes `growth-boxes` and `growth-robots` have the same keys; `precision`\nhas `dt`, "
      "`us_per_simulated_s` and `error_rad`, `compile` has `bytes` and `us`, `allocations` has "
      "`of`, `layer`,\n`allocations_per_step` and `engine_allocations_per_step`, `rays` and "
      "`cameras` what their programs print.\n";
  std::ofstream file(page);
  file << out;
  file.close();
  if (!file) throw std::runtime_error(fmt::format("cannot write '{}'", path));
}

}  // namespace cogrsim::bench
