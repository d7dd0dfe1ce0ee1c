// A running world on MuJoCo.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine.h"
#include "program.h"

#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/warnings.h"
#include "cogrsim/physics/world.h"

namespace cogrsim::mujoco {

class MujocoWorld final : public World,
                          public JointReactions,
                          public KinematicDrive,
                          public ExternalForces,
                          public WorldWarnings {
 public:
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return program_->scene; }
  double time() const override { return time_; }
  StepResult step(double dt, const std::vector<Drive>& drives) override;
  void get_state(WorldState& out) const override;
  Result<> set_state(const WorldState& state) override;
  void get_contacts(std::vector<Contact>& out) const override;
  Result<> add(const SceneModelPtr& next) override { return change_to(next, SceneStep::add); }
  Result<> remove(const SceneModelPtr& next) override { return change_to(next, SceneStep::remove); }
  Result<> change(const SceneModelPtr& next) override { return change_to(next, SceneStep::change); }
  SnapshotPtr save() const override;
  Result<> restore(const SnapshotPtr& snapshot) override;
  Result<> reset() override;
  std::vector<Diagnostic> warnings() const override { return program_->warnings; }
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces, WorldWarnings>(this, id);
  }
  void get_joint_reactions(std::vector<Wrench>& out) const override;
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  struct Snapshot;
  /// Positions, velocities and what the solver starts from: all that MuJoCo holds between steps.
  struct Coordinates {
    std::vector<double> qpos, qvel, warmstart;
  };
  /// To which coordinates mjData's poses and velocities of bodies belong.
  enum class Kinematics { none, before, now };

  MujocoWorld() = default;
  /// A copy of `program`'s model to step, and data for it. The world is as it was when it fails.
  Result<> adopt(const ProgramPtr& program);
  /// Data with memory for so many times the contacts of an ordinary scene, and the stack of
  /// MuJoCo's own rule.
  Result<> make_room(double contacts, double stack);
  Result<> change_to(const SceneModelPtr& next, SceneStep step);

  void set_drives(double dt, const std::vector<Drive>& drives);
  /// The speed of the axis of an actuator.
  double speed_of(std::size_t actuator) const;
  void apply_forces();
  void hold_kinematic();
  double response_of(int dof) const;
  void find_responses();
  StepResult diverged(int body, const std::string& what);
  /// The first body with a number beyond MuJoCo's bounds, or that its warnings are about; -1: none.
  int find_bad() const;

  void get_coordinates(Coordinates& out) const;
  void put_back(const Coordinates& from) const;
  void find_kinematics(Kinematics wanted) const;
  Pose pose_of(int body) const;
  Twist twist_of(int body) const;
  void read_tree_joint(std::size_t j, double* q, double* u) const;
  void read_efforts(WorldState& out) const;
  void put_kept_state();
  void put_joint(std::size_t j, const double* q, const double* u);
  void put_free(std::size_t b, const Pose& X, const Twist& V);
  void follow();
  void forget_reports();

  ProgramPtr initial_, program_;
  ModelOwner model_;  ///< stepped: its step, gains and bounds are those of the last step
  DataOwner data_;
  double contact_room_ = 1.0, stack_room_ = 1.0;
  double time_ = 0.0;
  Coordinates before_;                ///< the last step
  std::vector<double> responses_;     ///< by actuator, what a unit of effort gives its axis
  ImplicitDrives laws_;               ///< by actuator
  bool has_external_forces_ = false;  ///< xfrc_applied has forces on bodies
  bool stepped_ = false;              ///< mjData holds what the last step found
  bool unchecked_ = true;             ///< its coordinates did not come from a step
  mutable Kinematics kinematics_ = Kinematics::none;
  mutable std::vector<double> scratch_;
  std::vector<Twist> kinematic_;  ///< by body, as set
  /// What mjData does not have: of removed and static bodies, coordinates of joints that are no
  /// joints of MuJoCo's, and all reports where no step was made since they were.
  WorldState kept_;
  std::vector<Contact> kept_contacts_;
  std::vector<Wrench> kept_reactions_;
};

}  // namespace cogrsim::mujoco
