#include "support.h"

namespace cogrsim::test {

std::shared_ptr<PluginLoader> loader() {
  static const auto kLoader =
      std::make_shared<PluginLoader>(std::vector<std::string>{COGRSIM_TEST_MINDS});
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

void Flywheel::add_mind(const std::string& mode, double rate, FaultPolicy policy) {
  ControllerModel mind;
  mind.plugin = "probe_mind";
  mind.rate = rate;
  mind.on_fault = policy;
  mind.parameters["mode"] = mode;
  BareFlywheel::add_mind(mind);
}

ModelBuilder falling_ball() {
  ModelBuilder builder("ball");
  builder.sphere("ball", 0.1, 1.0, Pose(Vec3(0, 0, 10), Quat(1, 0, 0, 0)));
  return builder;
}

}  // namespace cogrsim::test
