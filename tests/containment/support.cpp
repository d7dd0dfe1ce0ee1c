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
  folders.emplace_back(COGRSIM_TEST_CONTROLLERS);
  return std::make_shared<PluginLoader>(folders);
}

SceneModelPtr flywheel(const ControllerModel& controller) {
  BareFlywheel robot;
  robot.add_controller(controller);
  return robot.builder.build();
}

ControllerModel trouble(const std::string& what) {
  ControllerModel controller;
  controller.plugin = "trouble";
  controller.rate = 100.0;
  controller.isolation = Isolation::process;
  controller.parameters["what"] = what;
  return controller;
}

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::shared_ptr<PluginLoader> plugins) {
  SimulationOptions options;
  options.backend = backend;
  return simulate(scene, options, std::move(plugins));
}

std::string refusal(const SceneModelPtr& scene) { return refusal(scene, "bullet", loader()); }

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
