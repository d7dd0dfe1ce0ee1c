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
// No object that ends with the program: a module that has this, too, would end it again.
inline constexpr PolicySetting kPolicySettings[] = {
    {"command", "what is asked of the policy"},
    {"push",
     "change of the base's velocity by a push of 0.1 s every 3 s, to a side drawn from the seed"},
    {"friction", "factor on the friction of all surfaces"},
    {"payload", "mass at the base's centre of mass"},
    {"delay", "of the actions: the card's actions.delay"},
    {"rotor-inertia", "factor on that of all joints, or a list for those of the card"},
    {"joint-friction", "likewise"},
    {"joint-damping", "likewise"},
    {"contact-stiffness", "of all surfaces"},
    {"effort", "factor on the limits of the motors' efforts"},
    {"drives", "engine; per-step or per-decision: servos as a law of the card's, then or then"},
    {"step", "of the physics"},
    {"start", "0: without the disturbance that is drawn from the seed"},
};

/// Reads a card and all that it names, with these settings, and compares them.
PolicyScene load_policy(const std::string& card, const std::vector<std::string>& plugin_paths,
                        const PolicySettings& settings = {});

/// The robot of a card that is not written yet, with motors for its actions. nullptr: `found` has why.
SceneModelPtr load_policy_robot(const PolicyCard& card,
                                const std::vector<std::string>& plugin_paths,
                                std::vector<Diagnostic>& found);

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
