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
  auto simulation = Simulation::create(scene, options, loader());
  if (!simulation) {
    for (const Diagnostic& d : simulation.error()) UNSCOPED_INFO(d.code << " " << d.message);
  }
  REQUIRE(simulation);
  return std::move(*simulation);
}

std::string refusal(const SceneModelPtr& scene, const std::string& backend) {
  SimulationOptions options;
  options.backend = backend;
  auto simulation = Simulation::create(scene, options, loader());
  REQUIRE_FALSE(simulation);
  std::string out;
  for (const Diagnostic& d : simulation.error())
    out += d.code + " " + d.message + "\n" + d.help + "\n";
  return out;
}

Flywheel::Flywheel(MotorMode mode) {
  builder.model.physics.gravity = Vec3::Zero();
  wheel = builder.body("bot.wheel", 1.0, Vec3(kInertia, kInertia, kInertia).asDiagonal(), Pose{});
  joint = builder.joint("bot.axle", JointType::hinge, kWorld, wheel, Pose{});
  assembly = builder.assembly("bot", {wheel}, {joint});
  motor = builder.motor("bot.left", joint, mode);
  builder.model.motors[0].assembly = assembly;
  SensorModel encoder;
  encoder.name = "bot.encoder";
  encoder.type = "encoder";
  encoder.joint = joint;
  encoder.assembly = assembly;
  builder.model.sensors.push_back(encoder);
}

void Flywheel::add_mind(const std::string& mode, double rate, FaultPolicy policy) {
  ControllerModel mind;
  mind.name = "bot.mind";
  mind.plugin = "probe_mind";
  mind.rate = rate;
  mind.on_fault = policy;
  mind.assembly = assembly;
  mind.parameters["mode"] = mode;
  builder.model.controllers.push_back(mind);
}

std::string messages_of(const Simulation& simulation) {
  std::string out;
  for (const RunMessage& m : simulation.messages()) out += m.source + ": " + m.message + "\n";
  return out;
}

ModelBuilder falling_ball() {
  ModelBuilder builder("ball");
  builder.sphere("ball", 0.1, 1.0, Pose(Vec3(0, 0, 10), Quat(1, 0, 0, 0)));
  return builder;
}

}  // namespace cogrsim::test
