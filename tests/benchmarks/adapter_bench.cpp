// Cost of a process of its own for an engine: a step with drives for a robot of 30 bodies, state and
// eight contacts back, by an engine that does nothing.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/model/builder.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/plugin/loader.h"

using namespace cogrsim;

namespace {

constexpr int kBodies = 30, kSteps = 20000;

/// A chain with a motor in each joint.
SceneModelPtr robot() {
  ModelBuilder builder;
  for (int b = 0; b < kBodies; ++b) {
    builder.sphere("body_" + std::to_string(b), 0.1, 1.0, Pose());
    if (b == 0) continue;
    const int joint =
        builder.joint("joint_" + std::to_string(b), JointType::hinge, b - 1, b, Pose());
    builder.motor("motor_" + std::to_string(b), joint, MotorMode::velocity);
  }
  return builder.build();
}

void measure(const std::string& language, World& world, bool contacts) {
  const std::vector<Drive> drives(world.model()->motors.size());
  WorldState state;
  std::vector<Contact> found;
  std::vector<double> times;
  for (int step = 0; step < kSteps; ++step) {
    const auto begin = std::chrono::steady_clock::now();
    const StepResult result = world.step(0.001, drives);
    if (contacts) world.get_contacts(found);
    world.get_state(state);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    if (result.status != StepStatus::ok) {
      std::fprintf(stderr, "%s\n", result.message.c_str());
      std::exit(1);
    }
    times.push_back(took.count());
  }
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * (kSteps - 1))];
  };
  std::printf("%-8s %-9s %8.1f %8.1f %8.1f\n", language.c_str(), contacts ? "contacts" : "state",
              at(0.1), at(0.5), at(0.9));
}

}  // namespace

int main(int count, char** arguments) {
  namespace fs = std::filesystem;
  if (count != 3) {
    std::fprintf(stderr, "usage: %s FOLDER-OF-THE-LIBRARIES FOLDER-OF-THE-ADAPTERS\n",
                 arguments[0]);
    return 2;
  }
  const test::TemporaryFolder folder;
  std::printf("%-8s %-9s %8s %8s %8s   [us], %d steps, %d bodies\n", "", "", "10 %", "median",
              "90 %", kSteps, kBodies);
  for (const auto& [name, program, file, library] :
       {std::tuple{"js", "node", "still.mjs", "cogrsim_backend.mjs"},
        std::tuple{"python", "python3", "still.py", "cogrsim_backend.py"}}) {
    const std::string own = std::string(name) + "/";
    folder.write(own + "backend.json", std::string("{\"name\": \"") + name +
                                           "\", \"engine\": \"still\", \"protocol\": 1, "
                                           "\"command\": [\"" +
                                           program + "\", \"" + file + "\"]}");
    fs::copy_file(fs::path(arguments[2]) / file, folder / (own + file));
    fs::copy_file(fs::path(arguments[1]) / library, folder / (own + library));
    PluginLoader loader({folder.path.string()});
    const auto backend = loader.backend(name);
    auto world = backend ? (*backend)->create_world(robot())
                         : Result<std::unique_ptr<World>>(tl::unexpected(backend.error()));
    if (!world) {
      std::printf("%-8s not measured: %s\n", name, world.error().message.c_str());
      continue;
    }
    for (const bool contacts : {false, true}) measure(name, **world, contacts);
  }
}
