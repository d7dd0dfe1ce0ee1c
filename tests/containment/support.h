// Scenes with controllers in-process or out-of-process.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "../support/flywheel.h"
#include "../support/runs.h"

namespace cogrsim::test {

std::shared_ptr<PluginLoader> loader(const std::string& more = {});

/// A flywheel with a controller.
SceneModelPtr flywheel(const ControllerModel& controller);

/// The controller "trouble", out-of-process.
ControllerModel trouble(const std::string& what);

std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::shared_ptr<PluginLoader> plugins = loader());
/// On bullet.
std::string refusal(const SceneModelPtr& scene);

/// Processes whose parent is `parent`, and theirs.
std::vector<pid_t> descendants(pid_t parent);
/// Whether a process exists and is not a zombie.
bool alive(pid_t process);

}  // namespace cogrsim::test
