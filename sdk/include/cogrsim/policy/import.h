// What other tools write beside a trained policy, as a policy card.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/policy/card.h"

namespace cogrsim {

/// Files of one policy, read:
///   Isaac Lab's IO_descriptors.yaml, and the env.yaml of its training;
///   the YAML files of unitree_rl_gym's deploy_mujoco and deploy_real;
///   deploy.yaml of unitree_rl_lab, with the env.yaml beside it;
///   the scripts play_*.py of MuJoCo Playground;
///   an ONNX file whose metadata has joints, gains and scales, as mjlab writes them.
///
/// What they say becomes a card. What they leave open is asked for, with the key of the card, and what a
/// card cannot express is refused; nothing is assumed.
class COGRSIM_API PolicySources {
 public:
  /// Reads them. nullptr: `found` has the errors: CG1501 to CG1503 and CG1506 at their places, CG1510 to
  /// CG1513 of networks.
  static std::unique_ptr<PolicySources> read(const std::vector<std::string>& paths,
                                             std::vector<Diagnostic>& found);
  ~PolicySources();

  /// Answers to what is left open, or other values: {"base", "pelvis"}, {"actions.kp", "[100, 80]"}, as in
  /// CardChanges. "~" leaves a key to its default. Errors: CG1502 there is no such place.
  void answer(const CardChanges& changes, std::vector<Diagnostic>& found);

  /// Files as seen from the present folder; empty: left open. `keyframe` is of an MJCF.
  std::string robot() const, keyframe() const, network() const;
  /// The kind of the actions, and whether there are gains: which motors the robot needs.
  PolicyActions drives() const;

  /// The card, for a file in `folder`. `robot` and `network` may be nullptr: what they would answer is asked
  /// for then. Empty: `found` has what is open (CG1514), what a card cannot say (CG1515), and sizes that do
  /// not add up (CG1506), at the places of the sources.
  std::string card(const std::string& folder, const SceneModel* robot, const PolicyNetwork* network,
                   std::vector<Diagnostic>& found);

 private:
  PolicySources();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
