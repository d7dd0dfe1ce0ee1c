#include "report.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <thread>

namespace cogrsim::bench {

namespace {

using Json = nlohmann::json;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// First line that a command prints.
std::string output_of(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) return "";
  char line[512] = "";
  if (!std::fgets(line, sizeof line, pipe)) line[0] = 0;
  pclose(pipe);
  std::string text = line;
  text.erase(text.find_last_not_of("\n") + 1);
  return text;
}

/// Value of the first line of a file that starts with `key`, behind the colon.
std::string entry(const char* path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t at = line.find_first_not_of(" \t", line.find(':') + 1);
    return at == std::string::npos ? "" : line.substr(at);
  }
  return "";
}

const Row* find(const std::vector<Row>& rows, const std::string& engine, const std::string& scene) {
  for (const Row& row : rows) {
    if (row.engine == engine && row.scene == scene && row.missing.empty()) return &row;
  }
  return nullptr;
}

bool starts_with(const std::string& text, const char* head) { return text.rfind(head, 0) == 0; }

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json spread(const Spread& s) { return {number(s.low), number(s.high)}; }

Json object_of(const Row& row, const std::string& scene) {
  Json out = {{"engine", row.engine}, {"version", row.version}, {"scene", scene},
              {"title", row.title},   {"bodies", row.bodies},   {"dt", row.dt}};
  if (!row.missing.empty()) {
    out["missing"] = row.missing;
    return out;
  }
  out.update({{"rounds", row.rounds},
              {"steps", row.steps},
              {"us_per_step", number(row.time.median)},
              {"us_per_step_quartiles", spread(row.time)},
              {"check",
               {{"what", row.check_text},
                {"value", number(row.check)},
                {"expected", number(row.expected)},
                {"within", row.within},
                {"agrees", row.agrees}}},
              {"build_us", row.build_us},
              {"memory_bytes", row.memory},
              {"settings", row.settings}});
  if (row.ratio) {
    out["ratio_to"] = row.raw;
    out["ratio"] = number(row.ratio->median);
    out["ratio_quartiles"] = spread(*row.ratio);
  }
  if (row.seen > 0) out["infrared_sum"] = row.seen;
  if (!row.note.empty()) out["note"] = row.note;
  return out;
}

Claim at_most(const std::string& what, double value, double bound, const std::string& where) {
  if (!std::isfinite(value)) return {what, "not measured", Claim::unknown};
  return {what, fmt::format("{:.3g}{}", value, where.empty() ? "" : " (" + where + ")"),
          value <= bound ? Claim::reached : Claim::missed};
}

/// The worst ratio of `engine` to what it is compared with, over scenes that `counts` takes.
template <class Counts>
Claim worst_ratio(const std::string& what, const std::vector<Row>& rows, const std::string& engine,
                  double bound, Counts counts) {
  double worst = kNan;
  std::string where;
  for (const Row& row : rows) {
    if (row.engine != engine || !row.ratio || !counts(row)) continue;
    const bool comparable = std::any_of(rows.begin(), rows.end(), [&](const Row& bare) {
      return bare.engine == row.raw && bare.title == row.title && bare.agrees;
    });
    if (!comparable) continue;
    if (std::isfinite(worst) && row.ratio->median <= worst) continue;
    worst = row.ratio->median;
    where = row.title;
  }
  return at_most(what, worst, bound, where);
}

void claim_real_time(const Results& results, std::vector<Claim>& claims) {
  for (const char* engine : {"cogrsim-bullet", "cogrsim-cogrsim"}) {
    const Row* row = find(results.table, engine, "robots-infrared");
    const double speed = row ? row->dt * 1e6 / row->time.median : kNan;
    Claim claim{
        fmt::format("100 robots with infrared sensors on {}: times real time, above 1", engine),
        "not measured", Claim::unknown};
    if (row) {
      claim.measured =
          fmt::format("{:.2f} ({:.0f} us for a step of 1 ms)", speed, row->time.median);
      claim.state = speed > 1 ? Claim::reached : Claim::missed;
    }
    claims.push_back(claim);
  }
}

}  // namespace

Machine this_machine(const std::string& repository) {
  Machine machine;
  machine.cpu = entry("/proc/cpuinfo", "model name");
  machine.cores = static_cast<int>(std::thread::hardware_concurrency());
  machine.memory = std::atof(entry("/proc/meminfo", "MemTotal").c_str()) * 1024;
  utsname name{};
  uname(&name);
  machine.system = output_of(". /etc/os-release && echo \"$PRETTY_NAME\"");
  machine.system += fmt::format(", {} {}", name.sysname, name.release);
#ifdef __clang__
  machine.compiler = "clang " __clang_version__;
#else
  machine.compiler = "g++ " __VERSION__;
#endif
  const std::time_t now = std::time(nullptr);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%d", std::gmtime(&now));
  machine.date = date;
  const std::string git = "git -C '" + repository + "' ";
  machine.commit = output_of(git + "rev-parse --short HEAD");
  if (!machine.commit.empty() &&
      !output_of(git + "status --porcelain --untracked-files=no").empty()) {
    machine.commit += " with changes";
  }
  return machine;
}

double growth_exponent(const std::vector<Row>& rows, const std::string& engine, int from) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Row& row : rows) {
    if (row.engine != engine || !row.missing.empty() || row.bodies < from) continue;
    const double x = std::log(row.bodies), y = std::log(row.time.median);
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return n < 2 ? kNan : (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::vector<Claim> claims_of(const Results& results) {
  std::vector<Claim> claims;
  std::vector<Row> all = results.table;
  for (const auto* growth : {&results.growth_boxes, &results.growth_robots}) {
    all.insert(all.end(), growth->begin(), growth->end());
  }
  claims.push_back(worst_ratio("Bullet backend against raw Bullet from 200 bodies up: at most 1.03",
                               all, "cogrsim-bullet", 1.03,
                               [](const Row& row) { return row.bodies >= 200; }));
  double worst = kNan;
  std::string where;
  for (const Row& row : results.table) {
    const Row* peer = find(results.table, "ignition-bullet", row.scene);
    if (row.engine != "cogrsim-bullet" || !row.missing.empty() || row.bodies < 10) continue;
    if (!peer || !peer->agrees) continue;  // a time for something else is no time to compare with
    const double ratio = row.time.median / peer->time.median;
    if (std::isfinite(worst) && ratio <= worst) continue;
    worst = ratio;
    where = row.title;
  }
  claims.push_back(at_most("Bullet backend against ignition-physics' bullet plugin: below 1", worst,
                           1.0, where));
  claims.push_back(worst_ratio(
      "`simbody` backend against raw Simbody on trees: at most 1.05", all, "cogrsim-simbody", 1.05,
      [](const Row& row) { return row.scene == "chain" || starts_with(row.scene, "robots"); }));
  const Row* mesh = find(results.table, "raw-simbody-mesh", "stack");
  Claim faster{
      "`cogrsim` backend against Simbody's mesh contact on a stack: at least 50 times faster",
      "not measured", Claim::unknown};
  if (mesh && mesh->ratio) {
    faster.measured = fmt::format("{:.0f} times", mesh->ratio->median);
    faster.state = mesh->ratio->median >= 50 ? Claim::reached : Claim::missed;
  }
  claims.push_back(faster);
  claim_real_time(results, claims);
  for (const char* engine : {"cogrsim-bullet", "cogrsim-cogrsim"}) {
    int most = 0;
    for (const Row& row : results.growth_boxes) {
      if (row.engine == engine && row.missing.empty()) most = std::max(most, row.bodies);
    }
    claims.push_back(at_most(
        fmt::format("Growth to 10,000 boxes on {}: time as number to the power of 1.15 at most",
                    engine),
        growth_exponent(results.growth_boxes, engine, 100), 1.15,
        most < 10000 ? fmt::format("to {} only", most) : ""));
  }
  double most = kNan;
  where.clear();
  for (const AllocationRow& row : results.allocations) {
    if (!row.missing.empty() || (std::isfinite(most) && row.ours <= most)) continue;
    most = row.ours;
    where = fmt::format("{}, {}, {}", row.engine, row.scene, row.layer);
  }
  claims.push_back(at_most("Allocations of our code in a step after warm-up: none", most, 0.0,
                           most > 0 ? where : ""));
  return claims;
}

void print_scene(const std::vector<Row>& rows) {
  if (rows.empty()) return;
  fmt::print("\n{}  ({}; {:g} ms steps)\n", rows.front().title, rows.front().check_text,
             rows.front().dt * 1e3);
  fmt::print("  {:<18} {:>11} {:>19} {:>7} {:>13}  {:>9}\n", "engine", "us/step", "quartiles",
             "ratio", "quartiles", "check");
  for (const Row& row : rows) {
    if (!row.missing.empty()) {
      fmt::print("  {:<18} {}\n", row.engine, row.missing);
      continue;
    }
    std::string ratio(21, ' ');
    if (row.ratio) {
      ratio = fmt::format("{:>7.2f} {:>6.2f} {:>6.2f}", row.ratio->median, row.ratio->low,
                          row.ratio->high);
    }
    fmt::print("  {:<18} {:>11.1f} {:>9.1f} {:>9.1f} {}  {:>9.5g}  {}\n", row.engine,
               row.time.median, row.time.low, row.time.high, ratio, row.check, row.note);
  }
}

void print_allocations(const std::vector<AllocationRow>& rows, int sites) {
  if (rows.empty()) return;
  fmt::print("\nAllocations per step, after warm-up\n  {:<18} {:<17} {:<11} {:>8} {:>10}\n",
             "engine", "scene", "layer", "ours", "engine's");
  for (const AllocationRow& row : rows) {
    if (!row.missing.empty()) {
      fmt::print("  {:<18} {:<17} {}\n", row.engine, row.scene, row.missing);
      continue;
    }
    fmt::print("  {:<18} {:<17} {:<11} {:>8.2f} {:>10.2f}\n", row.engine, row.scene, row.layer,
               row.ours, row.engines);
    int shown = 0;
    for (const Json& site : row.sites) {
      if (shown++ == sites) break;
      fmt::print("      {:.2f}/step, {:.0f} B each:\n", site.at("per_step").get<double>(),
                 site.at("bytes").get<double>());
      std::size_t frames = 0;
      for (const Json& frame : site.at("frames")) {
        if (frames++ == 8) break;
        fmt::print("          {}\n", frame.get<std::string>());
      }
    }
  }
}

void print_rest(const Results& results) {
  if (!results.precision.empty()) {
    fmt::print(
        "\nTumbling box: error of the orientation after {:g} s over cost\n  {:<18} {:>8} "
        "{:>14} {:>12}\n",
        kPrecisionTime, "engine", "dt [ms]", "us/simulated s", "error [rad]");
    for (const PrecisionPoint& point : results.precision) {
      if (point.missing.empty()) {
        fmt::print("  {:<18} {:>8g} {:>14.0f} {:>12.2e}\n", point.engine, point.dt * 1e3,
                   point.cost, point.error);
      } else {
        fmt::print("  {:<18} {}\n", point.engine, point.missing);
      }
    }
  }
  if (!results.compiling.empty()) {
    fmt::print("\nCompiling a scene\n  {:>8} {:>12} {:>14}\n", "bodies", "ms", "us per body");
    for (const CompilePoint& point : results.compiling) {
      fmt::print("  {:>8} {:>12.2f} {:>14.2f}\n", point.bodies, point.time.median / 1e3,
                 point.time.median / point.bodies);
    }
  }
  if (results.rays.is_array()) {
    fmt::print("\n1000 rays at 1000 bodies\n");
    for (const Json& row : results.rays) {
      fmt::print("  {:<18} {:>8.2f} million rays/s, {} wrong by 1 mm\n",
                 row.at("engine").get<std::string>(), row.at("rays_per_s").get<double>() / 1e6,
                 row.at("wrong_by_1_mm").get<int>());
    }
  } else if (!results.rays_missing.empty()) {
    fmt::print("\nRays: {}\n", results.rays_missing);
  }
  if (results.cameras.is_array()) {
    fmt::print("\nPictures per second\n");
    for (const Json& row : results.cameras) {
      fmt::print(
          "  {}x{}, {:>3} shapes, shadows {:<3}, {} samples: ours {:>7.1f}, MuJoCo {:>7.1f}, "
          "ratio {:.2f}\n",
          row.at("width").get<int>(), row.at("height").get<int>(), row.at("shapes").get<int>(),
          row.at("shadows").get<bool>() ? "yes" : "no", row.at("samples").get<int>(),
          row.at("frames_per_second").get<double>(),
          row.at("mujoco_frames_per_second").get<double>(), row.at("ratio").get<double>());
    }
  } else if (!results.cameras_missing.empty()) {
    fmt::print("\nCameras: {}\n", results.cameras_missing);
  }
  fmt::print("\n");
  for (const Claim& claim : claims_of(results)) {
    if (claim.state == Claim::unknown) continue;
    fmt::print("{:<12} {}: {}\n", claim.state == Claim::reached ? "reached" : "NOT REACHED",
               claim.what, claim.measured);
  }
}

Json to_json(const Results& results) {
  Json out = Json::array();
  for (const Row& row : results.table) out.push_back(object_of(row, row.scene));
  for (const Row& row : results.growth_boxes) out.push_back(object_of(row, "growth-boxes"));
  for (const Row& row : results.growth_robots) out.push_back(object_of(row, "growth-robots"));
  for (const PrecisionPoint& point : results.precision) {
    Json object = {
        {"engine", point.engine}, {"scene", "precision"}, {"bodies", 1}, {"dt", point.dt}};
    if (point.missing.empty()) {
      object.update({{"us_per_simulated_s", number(point.cost)},
                     {"us_per_step", number(point.cost * point.dt)},
                     {"error_rad", number(point.error)}});
    } else {
      object["missing"] = point.missing;
    }
    out.push_back(object);
  }
  for (const CompilePoint& point : results.compiling) {
    out.push_back({{"engine", "cogrsim"},
                   {"scene", "compile"},
                   {"bodies", point.bodies},
                   {"bytes", point.bytes},
                   {"us", point.time.median},
                   {"us_quartiles", spread(point.time)}});
  }
  for (const AllocationRow& row : results.allocations) {
    Json object = {{"engine", row.engine}, {"scene", "allocations"}, {"of", row.scene}};
    if (row.missing.empty()) {
      object.update({{"layer", row.layer},
                     {"allocations_per_step", row.ours},
                     {"engine_allocations_per_step", row.engines}});
    } else {
      object["missing"] = row.missing;
    }
    out.push_back(object);
  }
  const auto join = [&](const Json& rows, const char* scene, const char* engine,
                        const std::string& missing) {
    if (rows.is_array()) {
      for (Json row : rows) {
        row["scene"] = scene;
        if (!row.contains("engine")) row["engine"] = engine;
        out.push_back(row);
      }
    } else if (!missing.empty()) {
      out.push_back({{"engine", engine}, {"scene", scene}, {"missing", missing}});
    }
  };
  join(results.rays, "rays", "cogrsim", results.rays_missing);
  join(results.cameras, "cameras", "cogrsim", results.cameras_missing);
  return out;
}

}  // namespace cogrsim::bench
