#include "support.h"

namespace cogrsim::test {

std::shared_ptr<PluginLoader> loader() {
  static const auto kLoader =
      std::make_shared<PluginLoader>(std::vector<std::string>{COGRSIM_TEST_CONTROLLERS});
  return kLoader;
}

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     SimulationOptions options) {
  options.backend = backend;
  return simulate(scene, options, loader());
}

std::string refusal(const SceneModelPtr& scene, const std::string& backend) {
  return refusal(scene, backend, loader());
}

Flywheel::Flywheel(MotorMode mode) : BareFlywheel(mode) {
  SensorModel encoder;
  encoder.type = "encoder";
  encoder.joint = joint;
  add_sensor("bot.encoder", encoder);
}

void Flywheel::add_controller(const std::string& mode, double rate, FaultPolicy policy) {
  ControllerModel controller;
  controller.plugin = "probe_controller";
  controller.rate = rate;
  controller.on_fault = policy;
  controller.parameters["mode"] = mode;
  BareFlywheel::add_controller(controller);
}

ModelBuilder falling_ball() {
  ModelBuilder builder("ball");
  builder.sphere("ball", 0.1, 1.0, Pose(Vec3(0, 0, 10), Quat(1, 0, 0, 0)));
  return builder;
}

}  // namespace cogrsim::test
