// Runs a robot whose controller is in a separate process, has threads and children, and never ends.
#include <cstdio>

#include "../support/flywheel.h"
#include "cogrsim/simulation/simulation.h"

int main(int count, char** arguments) {
  using namespace cogrsim;
  if (count != 3) return 2;
  test::BareFlywheel robot;
  ControllerModel controller;
  controller.plugin = "trouble";
  controller.isolation = Isolation::process;
  controller.parameters["what"] = std::string(arguments[2]);
  robot.add_controller(controller);
  SimulationOptions options;
  options.backend = "bullet";
  auto simulation =
      Simulation::create(robot.builder.build(), options,
                         std::make_shared<PluginLoader>(std::vector<std::string>{arguments[1]}));
  if (!simulation) return 1;
  (*simulation)->run_until(0.02);
  std::puts("running");
  std::fflush(stdout);
  (*simulation)->run_until(1e9);
  return 0;
}
