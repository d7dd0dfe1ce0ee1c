// What a process of its own costs a controller: time of a step with an update in it, here and apart,
// taken in turns.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "../support/flywheel.h"
#include "cogrsim/simulation/simulation.h"

using namespace cogrsim;

namespace {

/// A wheel with a controller that hardly does anything, and `beams` distances to look at.
SceneModelPtr scene(Isolation isolation, int beams) {
  test::BareFlywheel robot;
  if (beams > 0) {
    SensorModel lidar;
    lidar.type = "lidar";
    lidar.body = robot.wheel;
    lidar.parameters["rays"] = std::int64_t{beams};
    robot.add_sensor("bot.scan", lidar);
  }
  ControllerModel mind;
  mind.plugin = "trouble";
  mind.isolation = isolation;
  robot.add_mind(mind);
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
    std::fprintf(stderr, "usage: %s FOLDER-OF-THE-TEST-MINDS\n", arguments[0]);
    return 2;
  }
  const auto loader = std::make_shared<PluginLoader>(std::vector<std::string>{arguments[1]});
  SimulationOptions options;
  options.backend = "bullet";
  std::printf("%-28s %10s %10s %10s\n", "median of 20000 steps", "here", "apart", "difference");
  for (const int beams : {0, 1000}) {
    auto here = Simulation::create(scene(Isolation::none, beams), options, loader);
    auto apart = Simulation::create(scene(Isolation::process, beams), options, loader);
    if (!here || !apart) {
      std::fprintf(stderr, "%s\n", (!here ? here : apart).error().front().message.c_str());
      return 1;
    }
    std::vector<double> times[2];
    for (int i = 0; i < 20000; ++i) {
      times[0].push_back(measured(**here));
      times[1].push_back(measured(**apart));
    }
    const double one = median(times[0]), other = median(times[1]);
    std::printf("%-28s %7.1f us %7.1f us %7.1f us\n",
                beams > 0 ? "with 1000 distances to read" : "a motor and no sensor", one, other,
                other - one);
  }
  return 0;
}
