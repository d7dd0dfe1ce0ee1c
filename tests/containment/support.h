// Scenes with controllers that live here or apart.
#pragma once

#include <catch2/catch.hpp>

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/model/builder.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::test {

std::shared_ptr<PluginLoader> loader(const std::string& more = {});

/// A flywheel in a robot "bot" with a motor "left" and an encoder, and a controller "bot.mind".
SceneModelPtr flywheel(const ControllerModel& mind);

/// The controller "trouble", apart.
ControllerModel trouble(const std::string& what);

/// A simulation, or the test fails with what create() said.
std::unique_ptr<Simulation> simulate(const SceneModelPtr& scene, const std::string& backend,
                                     std::shared_ptr<PluginLoader> plugins = loader());
/// What create() said of a scene that must be refused.
std::string refusal(const SceneModelPtr& scene);

std::string messages_of(const Simulation& simulation);

/// Processes whose parent is `parent`, and theirs.
std::vector<pid_t> descendants(pid_t parent);
/// Whether a process is there and no zombie.
bool alive(pid_t process);

}  // namespace cogrsim::test
