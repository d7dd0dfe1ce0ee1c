#include "measure.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

#include "child.h"
#include "cogrsim/figures/statistics.h"

namespace cogrsim::bench {

namespace {

using Json = nlohmann::json;

/// An engine at work on a scene.
struct Contestant {
  const Engine* engine = nullptr;
  std::unique_ptr<Child> child;
  Row row;
  double spent = 0;  ///< [s]
  std::vector<double> times, ratios;
  bool out = false;

  void give_up(const std::string& why) {
    row.missing = why;
    child.reset();
    out = true;
  }

  /// Asks and waits; gives up, and returns nothing, when there is no answer or a bad one.
  std::optional<Json> ask(const std::string& line, double limit) {
    const auto start = std::chrono::steady_clock::now();
    if (!line.empty()) child->say(line);
    auto answer = child->hear(limit);
    spent += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!answer) {
      const std::string what = line.empty() ? "building the scene" : "'" + line + "'";
      give_up(child->running() ? fmt::format("too slow: more than {:.0f} s for {}", limit, what)
                               : "its program broke off in " + what);
    } else if (answer->contains("unsupported")) {
      give_up(answer->at("unsupported").get<std::string>());
      return std::nullopt;
    } else if (answer->contains("failed")) {
      give_up(answer->at("failed").get<std::string>());
      return std::nullopt;
    }
    return answer;
  }

  /// Mean of some steps [us/step].
  std::optional<double> step(int steps, double limit) {
    const auto answer = ask(fmt::format("step {}", steps), limit);
    if (!answer) return std::nullopt;
    return answer->at("us").get<double>() / steps;
  }
};

void begin(Contestant& one, const Scene& scene, int count, const Effort& effort) {
  one.row.engine = one.engine->name;
  one.row.scene = scene.name;
  one.row.title = scene.title;
  one.row.dt = scene.step;
  one.row.check_text = scene.check_text;
  if (one.engine->command.empty()) {
    one.give_up("not installed: " + one.engine->package);
    return;
  }
  std::vector<std::string> command = one.engine->command;
  command.insert(command.end(), {"--scene", scene.name, "--count", std::to_string(count)});
  one.child = std::make_unique<Child>(command);
  const auto start = one.ask("", effort.limit);
  if (!start) return;
  one.row.version = start->at("version");
  one.row.settings = start->at("settings");
  one.row.bodies = start->at("bodies");
  one.row.build_us = start->at("build_us");
}

/// Up to the moment at which all are judged. An engine that would take longer than it may is
/// given up, and its cost is reported.
void warm_up(Contestant& one, const Scene& scene, const Effort& effort) {
  int done = 0;
  while (done < scene.warm_up) {
    const int steps = std::min(done == 0 ? 1 : 50, scene.warm_up - done);
    const auto time = one.step(steps, effort.limit);
    if (!time) return;
    done += steps;
    const double needed = *time * 1e-6 * (scene.warm_up - done);
    if (one.spent > effort.limit / 2 && one.spent + needed > effort.limit) {
      one.give_up(fmt::format("too slow: {:.0f} us/step after {} of {} steps of warm-up", *time,
                              done, scene.warm_up));
      return;
    }
  }
  const auto state = one.ask("state", effort.limit);
  if (!state) return;
  one.row.check = state->at("check").is_number() ? state->at("check").get<double>()
                                                 : std::numeric_limits<double>::quiet_NaN();
  one.row.seen = state->at("seen");
  one.row.memory = state->at("memory");
}

void judge(std::vector<Contestant>& all, const Scene& scene) {
  double expected = scene.expected;
  if (!std::isfinite(expected)) {
    std::vector<double> values;
    for (const Contestant& one : all) {
      if (!one.out && std::isfinite(one.row.check)) values.push_back(one.row.check);
    }
    expected = spread_of(values).median;
  }
  for (Contestant& one : all) {
    one.row.expected = expected;
    one.row.within = scene.within;
    one.row.agrees = std::abs(one.row.check - expected) <= scene.within * std::abs(expected);
  }
}

}  // namespace

std::vector<Engine> find_engines(const std::string& folder) {
  std::vector<Engine> engines;
  const auto add = [&](const std::string& name, std::vector<std::string> command,
                       const std::string& package, const std::string& raw) {
    command.front() = folder + "/" + command.front();
    if (access(command.front().c_str(), X_OK) != 0) command.clear();
    engines.push_back({name, command, package, raw});
  };
  add("raw-bullet", {"cogrsim_raw_bullet"}, "libbullet-dev", "");
  add("raw-simbody", {"cogrsim_raw_simbody"}, "libsimbody-dev", "");
  add("raw-ode", {"cogrsim_raw_ode"}, "libode-dev", "");
  add("raw-dart", {"cogrsim_raw_dart"}, "libdart-dev", "");
  // Ours: what can be loaded.
  std::vector<std::string> backends;
  {
    std::FILE* list = popen((folder + "/cogrsim_bench_backend --list").c_str(), "r");
    char line[256];
    while (list && std::fgets(line, sizeof line, list)) {
      backends.emplace_back(line, std::string(line).find_last_not_of("\n") + 1);
    }
    if (list) pclose(list);
  }
  for (const std::string& backend : backends) {
    add("cogrsim-" + backend, {"cogrsim_bench_backend", backend}, "", "raw-" + backend);
  }
  add("mujoco", {"cogrsim_raw_mujoco"}, "libmujoco-dev", "");
  for (const std::string engine : {"bullet", "dartsim"}) {
    add("ignition-" + engine, {"cogrsim_raw_ignition", engine},
        "libignition-physics-dev libignition-physics5-" + engine + "-plugin5",
        engine == "bullet" ? "raw-bullet" : "");
  }
  add("raw-simbody-mesh", {"cogrsim_raw_simbody_mesh"}, "libsimbody-dev", "cogrsim-cogrsim");
  return engines;
}

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {figures::quantile(values, 0.25), figures::quantile(values, 0.5),
          figures::quantile(values, 0.75)};
}

std::vector<Row> measure(const std::vector<Engine>& engines, const std::string& scene_name,
                         int count, const Effort& effort, const Progress& progress) {
  const Scene scene = make_scene(scene_name, count);
  std::vector<Contestant> all;
  for (const Engine& engine : engines) {
    Contestant one;
    one.engine = &engine;
    one.row.raw = engine.raw;
    progress(fmt::format("{}: {} warms up", scene.title, engine.name));
    begin(one, scene, count, effort);
    if (!one.out) warm_up(one, scene, effort);
    all.push_back(std::move(one));
  }
  judge(all, scene);
  // How many steps a round may have: as many as the scene wants, unless that lasts too long.
  for (Contestant& one : all) {
    if (one.out) continue;
    one.row.steps = 1;
    const auto time = one.step(1, effort.limit);
    if (!time) continue;
    const double fits =
        std::max(effort.limit - one.spent, 0.2 * effort.limit) * 1e6 / (*time * effort.rounds);
    one.row.steps = static_cast<int>(std::clamp(fits, 1.0, static_cast<double>(scene.round)));
    if (one.row.steps < scene.round) {
      one.row.note = fmt::format("rounds of {} steps only", one.row.steps);
    }
  }
  for (int round = 0; round < effort.rounds; ++round) {
    progress(fmt::format("{}: round {} of {}", scene.title, round + 1, effort.rounds));
    for (Contestant& one : all) {
      if (one.out) continue;
      const auto time = one.step(one.row.steps, effort.limit);
      if (time) one.times.push_back(*time);
    }
    // Ratios of neighbouring rounds: whatever else the machine does hits both sides.
    for (Contestant& one : all) {
      const auto raw = std::find_if(all.begin(), all.end(), [&](const Contestant& other) {
        return !one.engine->raw.empty() && other.engine->name == one.engine->raw;
      });
      if (one.out || raw == all.end() || raw->out) continue;
      one.ratios.push_back(one.times.back() / raw->times.back());
    }
  }
  std::vector<Row> rows;
  for (Contestant& one : all) {
    if (!one.out) {
      one.row.rounds = static_cast<int>(one.times.size());
      one.row.time = spread_of(one.times);
      if (!one.ratios.empty()) one.row.ratio = spread_of(one.ratios);
      if (!one.row.agrees) {
        one.row.note += one.row.note.empty() ? "does something else" : "; does something else";
      }
    }
    rows.push_back(std::move(one.row));
  }
  return rows;
}

}  // namespace cogrsim::bench
