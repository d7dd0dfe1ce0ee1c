// The scene in which a policy runs: the robot of its card, with the sensor and the controller it needs.
#pragma once

#include <map>
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
  CardChanges changes;  ///< of the card, as it was read
  std::vector<Diagnostic> found;
  std::vector<std::string> files;  ///< that an imported robot was read from
};

/// What a run has in place of the card and its robot; see kPolicySettings.
using PolicySettings = std::map<std::string, std::string>;

/// A setting that is no key of a card.
struct PolicySetting {
  const char *name, *meaning;
};
extern const std::vector<PolicySetting> kPolicySettings;

/// Reads a card and all that it names, with these settings, and compares them.
PolicyScene load_policy(const std::string& card, const std::vector<std::string>& plugin_paths,
                        const PolicySettings& settings = {});

/// A number of the settings in SI units; `other` where there is none. Errors: not a number, or of another
/// unit.
Result<double> setting_number(const PolicySettings& settings, const std::string& name,
                              const std::string& unit, double other);

/// Of all files that make its runs.
std::uint64_t hash_of_policy(const PolicyScene& scene);

/// Whether a body is one of the robot's: of the outermost assembly around its base.
bool is_of_robot(const SceneModel& model, const PolicyRobot& robot, int body);

/// The model with a controller that has this command (empty: the card's). Precondition: no errors were
/// found. Errors: the robot's parts are in no assembly.
Result<SceneModelPtr> with_policy(const PolicyScene& scene, const std::vector<double>& command);

}  // namespace cogrsim::cli
