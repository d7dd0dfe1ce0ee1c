// A running world on MuJoCo.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine.h"
#include "program.h"

#include "cogrsim/physics/world.h"

namespace cogrsim::mujoco {

class MujocoWorld final : public World, public JointReactions, public KinematicDrive {
 public:
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return program_->scene; }
  double time() const override { return time_; }
  StepResult step(double dt, const std::vector<Drive>& drives) override;
  void get_state(WorldState& out) const override;
  Result<> set_state(const WorldState& state) override;
  void get_contacts(std::vector<Contact>& out) const override;
  Result<> add(const SceneModelPtr& next) override;
  Result<> remove(const SceneModelPtr& next) override;
  Result<> change(const SceneModelPtr& next) override;
  SnapshotPtr save() const override;
  Result<> restore(const SnapshotPtr& snapshot) override;
  Result<> reset() override;
  void* extension(std::string_view id) override;
  void get_joint_reactions(std::vector<Wrench>& out) const override;
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  struct Snapshot;
  /// Positions, velocities and what the solver starts from: all that MuJoCo keeps between steps.
  struct Coordinates {
    std::vector<double> qpos, qvel, warmstart;
  };
  /// To which coordinates mjData's poses and velocities of bodies belong.
  enum class Kinematics { none, before, now };

  MujocoWorld() = default;
  /// A copy of `program`'s model to step, and data with room for its start. The world is as it was
  /// when it fails.
  Result<> adopt(const ProgramPtr& program);
  void start();
  Result<> make_room(int contacts, int rows, int stack);
  bool make_more_room(const std::string& lack);

  Coordinates coordinates() const;
  void keep_before();
  void put_back(const Coordinates& from) const;
  void set_drives(double dt, const std::vector<Drive>& drives);
  void hold_kinematic();
  void move_kinematic(double dt);
  StepResult diverged(int body, const std::string& what);
  int find_bad() const;
  int body_of_dof(int dof) const;
  int body_of_motor(int actuator) const;

  void see(Kinematics wanted) const;
  Pose pose_of(int body) const;
  Twist twist_of(int body) const;
  void read_joint(std::size_t j, double* q, double* u) const;
  void read_efforts(WorldState& out) const;
  void follow(std::vector<double>& positions) const;
  void put_joint(std::size_t j, const double* q, const double* u);
  void put_free(std::size_t b, const Pose& X, const Twist& V);
  void forget_reports();

  /// Makes MuJoCo's model anew for `next`. `attached`: joints between bodies that were there before;
  /// `stopped`: bodies that stand still now; what `sudden` bodies hang on takes an impact.
  Result<> become(const SceneModelPtr& next, const std::vector<int>& attached,
                  const std::vector<int>& stopped, const std::vector<int>& sudden);
  void carry_over(const Program& old, const Coordinates& was);
  void join(const std::vector<int>& sudden);
  Wrench loop_reaction(std::size_t j) const;

  ProgramPtr initial_, program_;
  ModelOwner model_;  ///< stepped: its step, gains and bounds are those of the last step
  DataOwner data_;
  double time_ = 0.0;
  double dt_ = 0.0;        ///< of the last step
  Coordinates before_;     ///< the last step
  bool stepped_ = false;   ///< mjData holds what the last step found
  bool unchecked_ = true;  ///< its coordinates did not come from a step
  mutable Kinematics seen_ = Kinematics::none;
  mutable std::vector<double> scratch_;
  std::vector<Twist> kinematic_;  ///< by body, what it was told
  /// What mjData does not have: of removed and static bodies, coordinates of joints that are no
  /// joints of MuJoCo's, and all reports where no step was made since they were.
  WorldState kept_;
  std::vector<Contact> kept_contacts_;
  std::vector<Wrench> kept_reactions_;
};

}  // namespace cogrsim::mujoco
