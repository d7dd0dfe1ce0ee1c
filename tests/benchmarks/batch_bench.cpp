// How many worlds a batch steps per second, on one thread and on more, beside a plain loop over the
// same simulations.
//
//     cogrsim_batch_bench [--rounds N] [--worlds N] [--threads N] [--json]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "cogrsim/model/builder.h"
#include "cogrsim/simulation/batch.h"

using namespace cogrsim;

namespace {

constexpr int kSteps = 10;  // of 1 ms in a call: a controller's period of 10 ms

// A pole on a cart: as small as a world gets, so that what the batch itself costs shows most.
SceneModelPtr cart() {
  ModelBuilder b("cart and pole");
  const Pose at(Vec3(0, 0, 0.5), Quat(1, 0, 0, 0));
  const int base = b.box("base", Vec3(0.2, 0.1, 0.06), 1.0, at);
  const int pole = b.cylinder("pole", 0.015, 0.6, 0.3, Pose(Vec3(0, 0, 0.8), Quat(1, 0, 0, 0)));
  const int rail = b.joint("rail", JointType::slider, kWorld, base,
                           Pose(at.p, Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX())));
  b.joint("pivot", JointType::hinge, base, pole,
          Pose(at.p, Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY())));
  b.motor("push", rail, MotorMode::torque);
  return b.build();
}

// Thirty links that hang askew and swing.
SceneModelPtr chain() {
  constexpr int kLinks = 30;
  constexpr double kLength = 0.2;
  ModelBuilder b("30-link chain");
  int parent = kWorld;
  for (int i = 0; i < kLinks; ++i) {
    const Vec3 start(kLength * i, 0, 5);
    const int link = b.box(fmt::format("link_{}", i), Vec3(kLength, 0.04, 0.04), 1.0,
                           Pose(start + Vec3(kLength / 2, 0, 0), Quat(1, 0, 0, 0)));
    b.joint(fmt::format("joint_{}", i), JointType::hinge, parent, link,
            Pose(start, Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY())));
    parent = link;
  }
  return b.build();
}

// Twenty boxes in the lowest row, one at the top.
SceneModelPtr pyramid() {
  constexpr int kBase = 20;
  constexpr double kSize = 0.5, kPitch = 0.55;
  ModelBuilder b("210-box pyramid");
  b.plane("floor");
  for (int row = 0; row < kBase; ++row) {
    for (int i = 0; i < kBase - row; ++i) {
      b.box(fmt::format("box_{}_{}", row, i), Vec3(kSize, kSize, kSize), 1.0,
            Pose(Vec3(kPitch * (i + 0.5 * row), 0, kSize * (row + 0.5)), Quat(1, 0, 0, 0)));
    }
  }
  return b.build();
}

struct Subject {
  const char* name;
  SceneModelPtr scene;
  const char* signal;
  std::vector<std::string> motors;
};

std::vector<Subject> subjects() {
  return {{"cart and pole", cart(), "pivot.position", {"push"}},
          {"30-link chain", chain(), "energy.total", {}},
          {"210-box pyramid", pyramid(), "energy.total", {}}};
}

struct Quartiles {
  double lower = 0.0, median = 0.0, upper = 0.0;
};

Quartiles quartiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto i = static_cast<std::size_t>(place);
    const std::size_t j = std::min(i + 1, values.size() - 1);
    return values[i] + (place - static_cast<double>(i)) * (values[j] - values[i]);
  };
  return {at(0.25), at(0.5), at(0.75)};
}

[[noreturn]] void give_up(const std::vector<Diagnostic>& why) {
  fmt::print(stderr, "{}\n", why.front().message);
  std::exit(1);
}

std::unique_ptr<Batch> make_batch(const Subject& subject, const std::string& backend, int worlds,
                                  int threads, const std::shared_ptr<PluginLoader>& loader) {
  BatchOptions options;
  options.backend = backend;
  options.threads = threads;
  options.actions = subject.motors;
  options.observations = {subject.signal};
  auto batch = Batch::create(subject.scene, worlds, options, loader);
  if (!batch) give_up(batch.error());
  return std::move(*batch);
}

template <class Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Measured {
  std::vector<double> loop;                  ///< [world steps/s] by round
  std::vector<std::vector<double>> batches;  ///< by number of threads less one, by round
  std::vector<double> resets;                ///< [s] of a world
};

Measured measure(const Subject& subject, const std::string& backend, int worlds, int threads,
                 int rounds, const std::shared_ptr<PluginLoader>& loader) {
  Measured out;
  std::vector<std::unique_ptr<Simulation>> alone;
  for (int i = 0; i < worlds; ++i) {
    SimulationOptions options;
    options.backend = backend;
    auto simulation = Simulation::create(subject.scene, options, loader);
    if (!simulation) give_up(simulation.error());
    alone.push_back(std::move(*simulation));
  }
  std::vector<std::unique_ptr<Batch>> batches;
  for (int t = 1; t <= threads; ++t) {
    batches.push_back(make_batch(subject, backend, worlds, t, loader));
  }
  out.batches.resize(batches.size());
  // As many calls as make a round of about 0.2 s on one thread.
  const double once = seconds([&] { batches[0]->step(kSteps); });
  const int calls = std::clamp(static_cast<int>(0.2 / once), 1, 1000);
  const double steps = static_cast<double>(calls) * kSteps * worlds;
  for (int r = 0; r <= rounds; ++r) {
    const double loop = seconds([&] {
      for (int c = 0; c < calls; ++c) {
        for (const auto& simulation : alone) {
          for (int k = 0; k < kSteps; ++k) simulation->step();
        }
      }
    });
    if (r > 0) out.loop.push_back(steps / loop);  // the first round warms up
    for (std::size_t t = 0; t < batches.size(); ++t) {
      const double time = seconds([&] {
        for (int c = 0; c < calls; ++c) batches[t]->step(kSteps);
      });
      if (r > 0) out.batches[t].push_back(steps / time);
    }
  }
  for (int i = 0; i < worlds; ++i) {
    out.resets.push_back(seconds([&] { static_cast<void>(batches[0]->reset(i)); }));
  }
  return out;
}

/// Quartiles of the rounds' own ratios, so that what slows a round down slows both sides.
Quartiles ratio(const std::vector<double>& above, const std::vector<double>& below) {
  std::vector<double> out;
  std::transform(above.begin(), above.end(), below.begin(), std::back_inserter(out),
                 [](double a, double b) { return a / b; });
  return quartiles(out);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Steps many worlds at once and says how many per second."};
  int rounds = 9, worlds = 64;
  int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  bool as_json = false;
  app.add_option("--rounds", rounds, "rounds, of which medians are taken")
      ->check(CLI::Range(1, 1000));
  app.add_option("--worlds", worlds, "worlds of a batch")->check(CLI::Range(1, 10000));
  app.add_option("--threads", threads, "up to so many threads; one per core if left out")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--json", as_json, "a JSON array instead of a table");
  CLI11_PARSE(app, argc, argv);

  const auto loader = std::make_shared<PluginLoader>();
  auto json = nlohmann::json::array();
  if (!as_json) {
    fmt::print("{} worlds, {} steps of 1 ms a call; medians of {} rounds [quartiles]\n\n", worlds,
               kSteps, rounds);
    fmt::print("{:<10} {:<16} {:>7} {:>14} {:>24} {:>11} {:>10}\n", "backend", "scene", "threads",
               "world steps/s", "beside a plain loop", "efficiency", "reset [us]");
  }
  for (const PluginPtr& plugin : loader->all()) {
    if (plugin->descriptor().kind != PluginKind::backend || plugin->is_program()) continue;
    const std::string& backend = plugin->descriptor().name;
    for (const Subject& subject : subjects()) {
      const Measured m = measure(subject, backend, worlds, threads, rounds, loader);
      const double reset = 1e6 * quartiles(m.resets).median;
      for (std::size_t t = 0; t < m.batches.size(); ++t) {
        const double rate = quartiles(m.batches[t]).median;
        const Quartiles beside = ratio(m.batches[t], m.loop);
        const double efficiency =
            ratio(m.batches[t], m.batches[0]).median / static_cast<double>(t + 1);
        if (as_json) {
          json.push_back({{"backend", backend},
                          {"scene", subject.name},
                          {"worlds", worlds},
                          {"threads", t + 1},
                          {"world_steps_per_second", rate},
                          {"ratio_to_loop", {beside.lower, beside.median, beside.upper}},
                          {"efficiency", efficiency},
                          {"reset_us", reset}});
        } else {
          fmt::print(
              "{:<10} {:<16} {:>7} {:>14.0f} {:>9.2f} [{:.2f} .. {:.2f}] {:>10.0f}% {:>10.0f}\n",
              backend, subject.name, t + 1, rate, beside.median, beside.lower, beside.upper,
              100.0 * efficiency, reset);
        }
      }
    }
  }
  if (as_json) fmt::print("{}\n", json.dump(2));
}
