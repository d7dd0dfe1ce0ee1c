// The scene in which a policy runs: the robot of its card, with the sensor and the controller it needs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/policy/card.h"
#include "common/scene_loading.h"

namespace cogrsim::cli {

struct PolicyScene {
  std::shared_ptr<PluginLoader> loader;
  std::shared_ptr<const PolicyCard> card;        ///< nullptr: it cannot be read
  std::shared_ptr<const PolicyNetwork> network;  ///< nullptr: it cannot be read
  SceneModelPtr model;                           ///< of the robot alone; nullptr: there are errors
  PolicyRobot robot;
  std::vector<Diagnostic> found;
};

/// Reads a card and all that it names, and compares them.
PolicyScene load_policy(const std::string& card, const std::vector<std::string>& plugin_paths);

/// The model with a controller that has this command (empty: the card's). Precondition: no errors were
/// found. Errors: the robot's parts are in no assembly.
Result<SceneModelPtr> with_policy(const PolicyScene& scene, const std::vector<double>& command);

}  // namespace cogrsim::cli
