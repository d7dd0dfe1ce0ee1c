// A running world on MuJoCo.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine.h"
#include "program.h"

#include "cogrsim/physics/hosted_world.h"

namespace cogrsim::mujoco {

class MujocoWorld final : public HostedWorld {
 public:
  std::vector<Diagnostic> warnings() const override { return program_->warnings; }

 private:
  /// Positions, velocities and what the solver starts from: all that MuJoCo holds between steps.
  struct Coordinates {
    std::vector<double> qpos, qvel, warmstart;
  };
  struct Memory final : HostedMemory {
    ProgramPtr program;
    Coordinates coordinates;
    std::vector<double> responses;
    std::vector<int> at_bound;
  };
  /// To which coordinates mjData's poses and velocities of bodies belong.
  enum class Kinematics { none, before, now };

  const char* engine_name() const override { return "mujoco"; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override;
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override;
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  void prepare_reading() const override { find_kinematics(Kinematics::now); }
  Pose pose(int body) const override;
  Twist twist(int body) const override;
  bool has_coordinates(int joint) const override { return program_->joints[joint].joint >= 0; }
  bool read_joint(int joint, double* q, double* u) const override;
  Result<> write(const WorldState& state) override;
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override;
  void read_contacts(std::vector<Contact>& out) const override;
  void read_reactions(std::vector<Wrench>& out) const override;
  MemoryPtr save_memory() const override;
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;
  void move_kinematic(int body) override;

  /// A copy of `program`'s model to step, and data for it. The world is as it was when it fails.
  Result<> adopt(const ProgramPtr& program);
  /// Data of `model` with memory for so many times the contacts of an ordinary scene, and the stack
  /// of MuJoCo's own rule.
  Result<> make_room(mjModel& model, double contacts, double stack);

  void set_drives(double dt, const std::vector<Drive>& drives);
  /// The speed of the axis of an actuator.
  double speed_of(std::size_t actuator) const;
  void apply_forces();
  void hold_kinematic();
  double response_of(int dof) const;
  void find_responses();
  StepResult lost(int body, const std::string& what);
  /// The first body with a number beyond MuJoCo's bounds, or that its warnings are about; -1: none.
  int find_bad() const;

  void get_coordinates(Coordinates& out) const;
  void put_back(const Coordinates& from) const;
  void find_kinematics(Kinematics wanted) const;
  /// The coordinates of joints from the `first` on came out of poses.
  void put_state(const WorldState& state, std::size_t first);
  void put_joint(std::size_t j, const double* q, const double* u);
  void put_free(std::size_t b, const Pose& X, const Twist& V);
  void forget_step();

  ProgramPtr initial_, program_;
  ModelOwner model_;  ///< stepped: its step, gains and bounds are those of the last step
  DataOwner data_;
  double contact_room_ = 1.0, stack_room_ = 1.0;
  Coordinates before_;                ///< the last step
  std::vector<double> responses_;     ///< by actuator, what a unit of effort gives its axis
  ImplicitDrives laws_;               ///< by actuator
  bool has_external_forces_ = false;  ///< xfrc_applied has forces on bodies
  bool stepped_ = false;              ///< mjData holds what the last step found
  bool unchecked_ = true;             ///< its coordinates did not come from a step
  mutable Kinematics kinematics_ = Kinematics::none;
  mutable std::vector<double> scratch_;
};

}  // namespace cogrsim::mujoco
