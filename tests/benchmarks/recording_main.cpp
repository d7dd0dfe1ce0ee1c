// What recording costs a run: the same scene stepped with and without a recorder, by turns.
//
//     cogrsim_recording_benchmark [ROUNDS]
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

constexpr int kBodies = 100;
constexpr int kSteps = 100;  // a round's, of 1 ms

// Boxes that lie on the floor in ten rows.
SceneModelPtr scene() {
  ModelBuilder builder("recording benchmark");
  builder.plane("floor");
  for (int i = 0; i < kBodies; ++i) {
    builder.box(fmt::format("box_{}", i), Vec3(0.2, 0.2, 0.2), 1.0,
                Pose(Vec3(0.5 * (i % 10), 0.5 * (i / 10), 0.101), Quat(1, 0, 0, 0)));
  }
  return builder.build();
}

std::unique_ptr<Simulation> simulate(const std::string& backend) {
  SimulationOptions options;
  options.backend = backend;
  auto simulation = Simulation::create(scene(), options, std::make_shared<PluginLoader>());
  if (!simulation) {
    fmt::print(stderr, "{}\n", simulation.error().front().message);
    std::exit(1);
  }
  return std::move(*simulation);
}

struct Times {
  double wall = 0.0,
         thread = 0.0;  // of a step: on the clock, and of the stepping thread alone [us]
};

double thread_time() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Times round(Simulation& simulation) {
  const auto start = std::chrono::steady_clock::now();
  const double before = thread_time();
  for (int i = 0; i < kSteps; ++i) simulation.step();
  const double thread = thread_time() - before;
  const double wall =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {1e6 * wall / kSteps, 1e6 * thread / kSteps};
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 51;
  fmt::print("{} bodies, steps of 1 ms as fast as they go, {} rounds of {} steps\n\n", kBodies,
             rounds, kSteps);
  fmt::print(
      "| backend | plain [us/step] | recorded [us/step] | ratio | ratio of the thread | "
      "more [us/step] | share of 1 ms | "
      "bytes/step | left out |\n|---|---|---|---|---|---|---|---|---|\n");
  const test::TemporaryFolder folder;
  const std::string path = folder / "benchmark.mcap";
  for (const char* backend : {"bullet", "cogrsim"}) {
    const auto plain = simulate(backend), recorded = simulate(backend);
    RecorderOptions options;
    options.path = path;
    auto recorder = Recorder::start(*recorded, options);
    if (!recorder) {
      fmt::print(stderr, "{}\n", recorder.error().text());
      return 1;
    }
    round(*plain);
    round(*recorded);
    std::vector<double> a, b, wall, thread, extra;
    for (int i = 0; i < rounds; ++i) {
      // First one, then the other first: what drifts hits both.
      const bool swapped = i % 2 == 1;
      const Times first = round(swapped ? *recorded : *plain);
      const Times second = round(swapped ? *plain : *recorded);
      const Times &without = swapped ? second : first, &with = swapped ? first : second;
      a.push_back(without.wall);
      b.push_back(with.wall);
      wall.push_back(with.wall / without.wall);
      thread.push_back(with.thread / without.thread);
      extra.push_back(with.thread - without.thread);
    }
    static_cast<void>((*recorder)->finish(RunStatus::completed));
    const auto recording = Recording::open(path);
    const double steps = static_cast<double>((rounds + 1) * kSteps);
    fmt::print("| {} | {:.1f} | {:.1f} | {:.3f} | {:.3f} | {:.1f} | {:.1f} % | {:.0f} | {} |\n",
               backend, median(a), median(b), median(wall), median(thread), median(extra),
               median(extra) / 10.0,
               recording ? static_cast<double>((*recording)->info().file_size) / steps : 0.0,
               recording ? std::to_string((*recording)->info().dropped) : "unreadable");
    std::filesystem::remove(path);
  }
}
