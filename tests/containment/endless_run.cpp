// Runs a robot whose controller is in a process of its own, has threads and children, and never ends.
#include <cstdio>

#include "cogrsim/model/builder.h"
#include "cogrsim/simulation/simulation.h"

int main(int count, char** arguments) {
  using namespace cogrsim;
  if (count != 3) return 2;
  ModelBuilder builder("endless");
  builder.model.physics.gravity = Vec3::Zero();
  const int wheel = builder.body("bot.wheel", 1.0, Mat3::Identity(), Pose{});
  const int joint = builder.joint("bot.axle", JointType::hinge, kWorld, wheel, Pose{});
  const int bot = builder.assembly("bot", {wheel}, {joint});
  builder.motor("bot.left", joint, MotorMode::velocity);
  builder.model.motors[0].assembly = bot;
  ControllerModel mind;
  mind.name = "bot.mind";
  mind.plugin = "trouble";
  mind.assembly = bot;
  mind.isolation = Isolation::process;
  mind.parameters["what"] = std::string(arguments[2]);
  builder.model.controllers.push_back(mind);
  SimulationOptions options;
  options.backend = "bullet";
  auto simulation =
      Simulation::create(builder.build(), options,
                         std::make_shared<PluginLoader>(std::vector<std::string>{arguments[1]}));
  if (!simulation) return 1;
  (*simulation)->run_until(0.02);
  std::puts("running");
  std::fflush(stdout);
  (*simulation)->run_until(1e9);
  return 0;
}
