#include "support.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace cogrsim::test {

namespace {

struct ProcessLine {
  char state = 'X';
  pid_t parent = 0;
};

ProcessLine line_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  std::getline(file, text);
  ProcessLine line;
  const std::size_t after = text.rfind(')');  // names may contain anything
  if (after == std::string::npos) return line;
  std::istringstream rest(text.substr(after + 1));
  rest >> line.state >> line.parent;
  return line;
}

}  // namespace

std::shared_ptr<PluginLoader> loader(const std::string& more) {
  std::vector<std::string> folders;
  if (!more.empty()) folders.push_back(more);
  folders.push_back(COGRSIM_TEST_MINDS);
  return std::make_shared<PluginLoader>(folders);
}

SceneModelPtr flywheel(const ControllerModel& mind) {
  ModelBuilder builder("flywheel");
  builder.model.physics.gravity = Vec3::Zero();
  const int wheel = builder.body("bot.wheel", 1.0, Vec3(0.02, 0.02, 0.02).asDiagonal(), Pose{});
  const int joint = builder.joint("bot.axle", JointType::hinge, kWorld, wheel, Pose{});
  const int bot = builder.assembly("bot", {wheel}, {joint});
  builder.motor("bot.left", joint, MotorMode::velocity);
  builder.model.motors[0].assembly = bot;
  builder.model.controllers.push_back(mind);
  builder.model.controllers[0].name = "bot.mind";
  builder.model.controllers[0].assembly = bot;
  return builder.build();
}

ControllerModel trouble(const std::string& what) {
  ControllerModel mind;
  mind.plugin = "trouble";
  mind.rate = 100.0;
  mind.isolation = Isolation::process;
  mind.parameters["what"] = what;
  return mind;
}

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::shared_ptr<PluginLoader> plugins) {
  SimulationOptions options;
  options.backend = backend;
  auto simulation = Simulation::create(scene, options, std::move(plugins));
  if (!simulation) {
    for (const Diagnostic& d : simulation.error()) UNSCOPED_INFO(d.code << " " << d.message);
  }
  REQUIRE(simulation);
  return std::move(*simulation);
}

std::string refusal(const SceneModelPtr& scene) {
  SimulationOptions options;
  options.backend = "bullet";
  auto simulation = Simulation::create(scene, options, loader());
  REQUIRE_FALSE(simulation);
  std::string out;
  for (const Diagnostic& d : simulation.error()) out += d.code + " " + d.message + "\n";
  return out;
}

std::string messages_of(const Simulation& simulation) {
  std::string out;
  for (const RunMessage& m : simulation.messages()) {
    out += std::to_string(m.time) + " " + m.source + ": " + m.message + "\n";
  }
  return out;
}

std::vector<pid_t> descendants(pid_t parent) {
  std::vector<pid_t> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto process = static_cast<pid_t>(std::stol(name));
    if (line_of(process).parent != parent) continue;
    out.push_back(process);
    for (const pid_t more : descendants(process)) out.push_back(more);
  }
  return out;
}

bool alive(pid_t process) {
  const char state = line_of(process).state;
  return state != 'X' && state != 'Z';
}

}  // namespace cogrsim::test
