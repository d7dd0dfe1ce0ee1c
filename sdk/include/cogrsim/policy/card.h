// Policy cards, `*.policy.yaml`: what a trained network reads and writes on which robot.
// docs/guide/policies.md is the reference of the format.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/policy/network.h"

namespace cogrsim {

enum class PolicyTerm {
  base_linear_velocity,
  base_angular_velocity,
  projected_gravity,
  base_height,
  joint_positions,
  joint_velocities,
  last_action,
  command,
  phase,
  constant
};

/// "base-linear-velocity", …
COGRSIM_API const char* to_string(PolicyTerm term);

/// One term of the observations. Its values are disturbed, clipped, less the mean, scaled and stacked, in
/// this order.
struct PolicyObservation : SourcePosition {
  PolicyTerm term = PolicyTerm::constant;
  std::vector<double> scale;  ///< one for all, or one per value
  std::vector<double> mean;   ///< subtracted before the scale; one per value
  std::optional<std::pair<double, double>> clip;
  int history = 1;                     ///< values of so many decisions, the oldest first
  bool newest_first = false;           ///< of the history
  double delay = 0.0;                  ///< age of what is observed [s]
  double uniform = 0.0, normal = 0.0;  ///< noise: half the width, standard deviation
  bool world = false;                  ///< velocities in the world's axes, not in the base's
  bool relative = true;                ///< joint positions less the default pose
  bool clipped = false;                ///< last action as clipped, not as the network gave it
  // Of the phase: sines and cosines of 2 pi (t f + offset), for each offset.
  double lowest = 1.0, highest = 1.0;  ///< frequency f at rest and at `fastest_at` [Hz]
  double fastest_at = 0.0;             ///< size of the command; 0: the frequency is the lowest
  double still = 0.0;                  ///< commands that are smaller hold all phases at half a turn
  std::vector<double> offsets{0.0};    ///< in turns
  bool cosines_first = false;
  std::vector<double> value;  ///< of the constant
  std::size_t commands = 3;   ///< numbers of the command

  /// Number of values without history.
  COGRSIM_API std::size_t width(std::size_t joints) const;
};

enum class PolicyActionKind { position, velocity, torque };

/// Target of joint i: offset_i + scale_i a_i, where a is the network's output, clipped.
struct PolicyActions : SourcePosition {
  PolicyActionKind kind = PolicyActionKind::position;
  std::vector<double> scale, offset;              ///< one for all, or one per joint
  std::optional<std::pair<double, double>> clip;  ///< of the network's output
  /// Gains with which motors in torque mode are driven towards the target in every step of the physics,
  /// torque = kp (target - q) - kd q', or kd (target - q') for velocities; empty: the robot's own drives.
  std::vector<double> kp, kd;
  std::vector<double> effort_limit;  ///< of that torque; empty: that of the motor
  /// Of motors whose torque falls with their speed, see Motor::stall_effort; both empty: of none.
  std::vector<double> stall_effort, no_load_speed;
  double delay = 0.0;  ///< between the decision and the target [s]
  /// The torque that is left of `effort` at the joint's `speed` [rad/s] or [m/s] of motor i.
  COGRSIM_API double limited(std::size_t i, double effort, double speed) const;
  bool per_decision =
      false;  ///< the drive law runs once per decision, and its torque holds until the next
};

/// A card. Lists per joint have one entry per joint after reading.
struct COGRSIM_API PolicyCard {
  std::string file;           ///< as the user named it
  std::string robot;          ///< path of a scene, or of a model that is imported
  std::string keyframe;       ///< of an MJCF; empty: its zero
  std::string base;           ///< body or frame whose motion is observed
  std::string network;        ///< path
  std::string input, output;  ///< names; empty: the only ones
  std::map<std::string, std::string>
      state;             ///< output that an input has in the next decision, by input
  double period = 0.02;  ///< between decisions [s]
  double step = 0.0;     ///< of the physics [s]; 0: the scene's
  std::vector<std::string> joints;
  std::vector<double> pose;  ///< default pose, per joint [rad] or [m]
  std::vector<PolicyObservation> observations;
  std::optional<std::pair<double, double>> clip;  ///< of all observations
  PolicyActions actions;
  std::vector<double> command;  ///< at the start of a run; three numbers by default
  /// Within which the command may be changed in a run; empty: not at all.
  std::vector<std::pair<double, double>> command_limits;
  /// Names and units of its numbers; empty: it has none.
  std::vector<std::pair<std::string, std::string>> command_names;
  double fallen_height = 0.0;  ///< of the base, below which the robot counts as fallen [m]
  double fallen_tilt = 1.0;    ///< of the base's z axis from the vertical, likewise [rad]
  /// Where the card has what it names: by key, "joints.3" for the entries of a list.
  std::map<std::string, SourcePosition> places;
  std::string text;  ///< of the file

  std::size_t observed() const;  ///< number of values that the network is given
};

/// Values that a card has in place of its own, in YAML, by key: {"actions.delay", "20 ms"}. Entries of
/// lists are numbers, and terms of the observations their names: "observations.command.scale". "~" takes a
/// value away.
using CardChanges = std::vector<std::pair<std::string, std::string>>;

/// Reads a card. nullptr: `found` has the errors, CG1501 to CG1504. Paths are relative to the card, and lie
/// in its folder or below it.
COGRSIM_API std::shared_ptr<const PolicyCard> read_policy_card(const std::string& path,
                                                               std::vector<Diagnostic>& found,
                                                               const CardChanges& changes = {});

/// Whether the sizes of observations and actions are those of the network's inputs and outputs: CG1506.
COGRSIM_API std::vector<Diagnostic> check_policy_network(const PolicyCard& card,
                                                         const PolicyNetwork& network);

/// What of a scene's elements a card names.
struct PolicyRobot {
  std::vector<int> joints,
      motors;         ///< per joint of the card, indices into the model; -1: not found
  int base = kWorld;  ///< body
  Pose X_BF;          ///< of the observed frame in it
};

/// Finds them. Adds what the scene does not have, with the nearest name (CG1505), and what its motors
/// cannot do (CG1507) to `found`.
COGRSIM_API PolicyRobot find_policy_robot(const PolicyCard& card, const SceneModel& model,
                                          std::vector<Diagnostic>& found);

/// The values of a card by the keys of CardChanges, each in YAML on one line, to compare cards. "observations"
/// has the names of the terms alone, "observations.all" all of them. Empty: it is no YAML.
COGRSIM_API CardChanges policy_card_values(const std::string& path);

/// A finding at a place of the card, with its line.
COGRSIM_API Diagnostic policy_finding(const PolicyCard& card, const std::string& place,
                                      std::string code, std::string message, std::string help = {});

/// The entry of `names` that `name` means: itself, or the only one that ends in "." and `name`; -1: none
/// or several.
COGRSIM_API int find_policy_name(const std::vector<std::string>& names, const std::string& name);

}  // namespace cogrsim
