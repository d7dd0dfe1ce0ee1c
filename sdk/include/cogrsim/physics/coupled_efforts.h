// Couplings of joints for engines that have none of their own.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// Finds the efforts of couplings before each step, for an engine that applies them over it. With the
/// mass matrix M of a tree of joints (tree_dynamics.h, refreshed every few steps), the efforts tau of
/// its drives, springs and dampers, and C the coefficients of its couplings (1 and -ratio), all else
/// that acted in the last step is
///
///     h f = M (u_n - u_(n-1)) - h (tau + C^T E)
///
/// and is taken to act again. Drives and dampers obey their laws at the end of the step (see Drive), and
/// E is what then makes C u_(n+1) = -b g / h: the couplings' rates take back the share b of their
/// errors g = q - offset - sum ratio q_i.
///
/// With M right, what changes between two steps (a contact) is an error of the rate for two steps;
/// where contacts or loops make the mechanism stiffer than M, it falls by sqrt(1 - true mobility /
/// C M^-1 C^T) a step, and stays stable.
///
/// All joints of a coupling feel E in the same step, so that no work is gained or lost between them
/// but E times the rate. The effort is bounded by Coupling::max_effort. A value: copying it saves it.
class COGRSIM_API CoupledEfforts {
 public:
  /// The couplings of a scene.
  void take_scene(const SceneModelPtr& model);
  bool empty() const { return !plan_; }
  /// All else acts otherwise from now on: the state was set.
  void forget();
  /// For a step of dt [s] that begins in `state`, whose motor_efforts are those of the last step.
  void find(double dt, const WorldState& state, const std::vector<Drive>& drives);
  /// By speed of the scene (joint_speeds) [N m], [N].
  const std::vector<double>& efforts() const { return by_speed_; }
  /// The efforts of the last step, on the axes that have them.
  void add_to(std::vector<double>& joint_efforts) const;

 private:
  struct Tree;
  struct Plan;
  struct Past;  ///< of a tree in the last step
  void find(const Tree& tree, Past& past, double dt, const WorldState& state,
            const std::vector<Drive>& drives);

  std::shared_ptr<const Plan> plan_;
  std::vector<std::shared_ptr<const Past>> past_;  ///< by tree
  std::vector<double> by_speed_;
  int age_ = 0;  ///< steps since mass matrices were found
};

}  // namespace cogrsim
