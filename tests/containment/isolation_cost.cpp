// Cost of a separate process for a controller: time of a step with an update, in-process and
// out-of-process, measured alternately.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "../support/flywheel.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

/// A wheel with a controller that does almost nothing, and `beams` distances to read.
SceneModelPtr scene(Isolation isolation, int beams) {
  test::BareFlywheel robot;
  if (beams > 0) {
    SensorModel lidar;
    lidar.type = "lidar";
    lidar.body = robot.wheel;
    lidar.parameters["rays"] = std::int64_t{beams};
    robot.add_sensor("bot.scan", lidar);
  }
  ControllerModel controller;
  controller.plugin = "trouble";
  controller.isolation = isolation;
  robot.add_controller(controller);
  return robot.builder.build();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// Of one step [us].
double measured(Simulation& simulation) {
  const auto begin = std::chrono::steady_clock::now();
  simulation.step();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
      .count();
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: %s FOLDER-OF-THE-TEST-CONTROLLERS\n", arguments[0]);
    return 2;
  }
  const auto loader = std::make_shared<PluginLoader>(std::vector<std::string>{arguments[1]});
  SimulationOptions options;
  options.backend = "bullet";
  std::printf("%-28s %12s %14s %10s\n", "median of 20000 steps", "in-process", "out-of-process",
              "difference");
  for (const int beams : {0, 1000}) {
    auto in_process = Simulation::create(scene(Isolation::none, beams), options, loader);
    auto out_of_process = Simulation::create(scene(Isolation::process, beams), options, loader);
    if (!in_process || !out_of_process) {
      const auto& failed = !in_process ? in_process : out_of_process;
      std::fprintf(stderr, "%s\n", failed.error().front().message.c_str());
      return 1;
    }
    std::vector<double> times[2];
    for (int i = 0; i < 20000; ++i) {
      times[0].push_back(measured(**in_process));
      times[1].push_back(measured(**out_of_process));
    }
    const double one = median(times[0]), other = median(times[1]);
    std::printf("%-28s %9.1f us %11.1f us %7.1f us\n",
                beams > 0 ? "with 1000 distances to read" : "a motor and no sensor", one, other,
                other - one);
  }
  return 0;
}
