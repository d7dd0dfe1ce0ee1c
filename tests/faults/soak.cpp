// Objects are added and removed for a long time: does the memory use stay constant?
//
//     cogrsim_soak [--minutes M] [--backend B] [--spawns N] [--quiet]
//
// One run after the other in one process, by Restart: in each N robots and balls are added, 20 per
// simulated second, and removed after a second, in a world with sensors and controllers. Removed
// objects keep their entries in the scene model until the restart (indices stay valid), so memory
// is measured right after restarts. Exit status 1: it grew.
#include <fmt/core.h>
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "cogrsim/dsl/loader_catalog.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kScene = R"(
<scene name="soak" version="1">
  <physics step="2 ms" seed="1"/>
  <plane name="floor"/>
  <template name="Robot"> <assembly name="body">
    <box name="chassis" size="20 14 4 cm" mass="1 kg" xyz="0 0 5 cm"/>
    <for var="name y" in="[['left', 1], ['right', -1]]">
      <cylinder name="wheel_${name}" radius="5 cm" length="2 cm" mass="150 g"
                xyz="0 ${y * 9 cm} 5 cm" rpy="90 0 0 deg"/>
      <hinge name="axle_${name}" parent="chassis" child="wheel_${name}" axis="0 0 -1"/>
      <motor name="${name}" joint="axle_${name}" mode="velocity" max-torque="0.6 N*m"/>
    </for>
    <pose name="tracker" on="chassis"/>
    <infrared name="eye" on="chassis" xyz="12 cm 0 0" range="2 .. 80 cm" rate="50 Hz"/>
    <controller plugin="diff_drive" rate="100 Hz">
      <set wheel_radius="5 cm" track="18 cm" speed="0.3 m/s" pose="tracker" waypoints="1 0  1 1  0 0"/>
    </controller>
  </assembly> </template>
  <template name="Ball"> <sphere name="ball" radius="5 cm" xyz="0 0 5 cm"/> </template>
</scene>
)";

/// Resident memory of this process [byte].
double resident() {
  std::ifstream file("/proc/self/statm");
  double size = 0.0, pages = 0.0;
  file >> size >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

/// Memory that the program holds, without what malloc caches [byte].
double held() {
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

struct Sample {
  double hours = 0.0, resident = 0.0, held = 0.0;  // [h], [byte]
};

struct Line {
  double at_start = 0.0, slope = 0.0;  // [byte], [byte/h]
};

/// Least squares.
Line fit(const std::vector<Sample>& samples, double Sample::*what) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (const Sample& s : samples) {
    n += 1.0;
    sx += s.hours;
    sy += s.*what;
    sxx += s.hours * s.hours;
    sxy += s.hours * s.*what;
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {(sy - slope * sx) / n, slope};
}

/// What leaks grows all along, malloc's arenas now and then by a jump: twice the growth of the half that
/// grows less [byte].
double steady_growth(const std::vector<Sample>& samples, double Sample::*what) {
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  const double first = fit({samples.begin(), middle}, what).slope;
  const double second = fit({middle, samples.end()}, what).slope;
  return std::min(first, second) * (samples.back().hours - samples.front().hours);
}

/// One run: `spawns` objects are added and removed. Returns the number of commands that were
/// refused.
int live(Simulation& run, int spawns) {
  const double start = run.time();
  int number = 0, refused = 0;
  std::vector<std::string> there;
  while (number < spawns) {
    Spawn spawn;
    spawn.of = number % 3 == 0 ? "Robot" : "Ball";
    spawn.name = fmt::format("guest_{}", number);
    // In a grid, so that its position is seldom occupied.
    spawn.pose.p = Vec3(0.5 * (number % 5), 0.5 * (number / 5 % 4), 0.01);
    spawn.lifetime = 1.0;
    run.send(spawn);
    ++number;
    run.run_until(start + 0.05 * number);
    if (run.status() != RunStatus::running) {
      fmt::print(stderr, "the run ended: {}\n", to_string(run.status()));
      return -1;
    }
  }
  run.run_until(start + 0.05 * number + 1.5);  // all of them were removed
  for (const RunMessage& message : run.messages()) {
    if (message.source == "command") ++refused;
  }
  return refused;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Lets things come and go for a long time and judges whether the memory stays flat."};
  double minutes = 60.0;
  int spawns = 300;
  std::string backend;
  bool quiet = false;
  app.add_option("--minutes", minutes, "how long, on the clock")->check(CLI::Range(0.05, 1e5));
  app.add_option("--spawns", spawns, "things that come and go in a run")
      ->check(CLI::Range(1, 20000));
  app.add_option("--backend", backend, "physics engine; bullet if left out");
  app.add_flag("--quiet", quiet, "the verdict alone");
  CLI11_PARSE(app, argc, argv);

  const auto loader = std::make_shared<PluginLoader>();
  dsl::LoaderCatalog catalog(loader);
  dsl::CompileOptions compile;
  compile.plugins = &catalog;
  const auto scene = dsl::compile_text(kScene, "soak.scene.xml", compile);
  if (!scene.ok()) {
    fmt::print(stderr, "{}", dsl::to_text(scene.diagnostics));
    return 2;
  }
  SimulationOptions options;
  options.backend = backend;
  auto made = Simulation::create(scene.model, options, loader);
  if (!made) {
    fmt::print(stderr, "{}", dsl::to_text(made.error()));
    return 2;
  }
  Simulation& run = **made;

  std::vector<Sample> samples;
  const auto start = Clock::now();
  const auto hours = [&] {
    return std::chrono::duration<double>(Clock::now() - start).count() / 3600;
  };
  std::size_t marks = 0;
  double grown = 0.0;
  int runs = 0;
  while (hours() < minutes / 60.0 || samples.size() < 8) {
    const int refused = live(run, spawns);
    if (refused < 0) return 1;
    if (refused > spawns / 2) {
      fmt::print(stderr, "{} of {} guests were refused: {}\n", refused, spawns,
                 run.messages().back().message);
      return 1;
    }
    const double full = held();
    marks = run.model()->bodies.size() - scene.model->bodies.size();
    run.send(Restart{});
    run.step();
    samples.push_back({hours(), resident(), held()});
    grown = full - samples.back().held;
    ++runs;
    if (!quiet) {
      fmt::print("{:9.4f} h  run {:5}  resident {:8.2f} MB  held {:8.3f} MB\n",
                 samples.back().hours, runs, samples.back().resident / 1e6,
                 samples.back().held / 1e6);
      std::fflush(stdout);
    }
  }

  // The first quarter is left out: caches, pools and malloc's arenas find their size.
  const std::vector<Sample> later(samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 4),
                                  samples.end());
  const double span = later.back().hours - later.front().hours;
  const Line memory = fit(later, &Sample::resident), own = fit(later, &Sample::held);
  const double resident_growth = steady_growth(later, &Sample::resident);
  const double held_growth = own.slope * span;
  fmt::print(
      "{}: {} runs, {} came and went; resident {:.2f} MB, growing {:+.3f} MB in {:.3f} h; "
      "held {:+.4f} MB; what was removed costs {:.0f} byte per body until the restart\n",
      run.backend().name(), runs, runs * spawns, memory.at_start / 1e6, resident_growth / 1e6, span,
      held_growth / 1e6, grown / static_cast<double>(marks));
  // A leak of one element per spawned object (a name of 16 byte, the least that malloc gives is 32)
  // would come to 32 byte times their number; of what is held, a quarter of that is not a leak but
  // rounding of the line (containers stand at other capacities from run to run). Resident memory
  // moves by malloc's trimming, whose thresholds of 128 kB grow with the blocks that are freed, and
  // by its arenas: up to 32 thresholds, and 1 % of itself. Beside what is held it shows only what does
  // not come from malloc.
  const double guests = static_cast<double>(later.size() * static_cast<std::size_t>(spawns));
  const double held_bound = 0.25 * 32.0 * guests + 64e3;
  const double resident_bound = 0.01 * memory.at_start + 32 * 128e3;
  if (held_growth > held_bound || resident_growth > resident_bound) {
    fmt::print("it grows: more than {:.3f} MB held or {:.3f} MB resident\n", held_bound / 1e6,
               resident_bound / 1e6);
    return 1;
  }
  return 0;
}
