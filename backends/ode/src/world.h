// A running world on ODE.
#pragma once

#include <memory>
#include <vector>

#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/scene_state.h"
#include "cogrsim/physics/world.h"
#include "engine.h"

namespace cogrsim::ode {

class OdeWorld final : public World,
                       public JointReactions,
                       public KinematicDrive,
                       public ExternalForces {
 public:
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return now_.model; }
  double time() const override { return now_.time; }
  StepResult step(double dt, const std::vector<Drive>& drives) override;
  void get_state(WorldState& out) const override;
  Result<> set_state(const WorldState& state) override;
  void get_contacts(std::vector<Contact>& out) const override { out = report().contacts; }
  Result<> add(const SceneModelPtr& next) override { return change_to(next, SceneStep::add); }
  Result<> remove(const SceneModelPtr& next) override { return change_to(next, SceneStep::remove); }
  Result<> change(const SceneModelPtr& next) override { return change_to(next, SceneStep::change); }
  SnapshotPtr save() const override;
  Result<> restore(const SnapshotPtr& snapshot) override;
  Result<> reset() override;
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces>(this, id);
  }
  void get_joint_reactions(std::vector<Wrench>& out) const override { out = report().reactions; }
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  /// All that a run knows beside what ODE's bodies hold, which are read into it after each step.
  struct Progress {
    SceneModelPtr model;
    double time = 0.0;
    unsigned long seed = 0;
    std::vector<Motion> motions;  ///< of ODE's bodies (nbody)
    /// (nbody) of static bodies, and the last of removed ones.
    std::vector<Pose> poses;
    std::vector<Twist> twists;  ///< the last of removed bodies (nbody)
    std::vector<double> q, u;   ///< of joints; u: the last of removed ones
    double turned = 0.0;  ///< how far anything may have turned since `q` was brought up to date
    double h = 0.0;       ///< of the last step; 0: the report is not of this world's

    /// Appends the start of bodies that are not in here yet, and of joints from `first_joint` on.
    void add_start(std::size_t first_joint);
  };
  struct Snapshot;

  OdeWorld() = default;
  Result<> start(const SceneModelPtr& model);
  /// Another engine for `progress.model`, with the motions of `progress`. Errors: as Engine::make;
  /// nothing has changed then.
  Result<> rebuild(Progress progress);
  Result<> change_to(const SceneModelPtr& next, SceneStep step);
  void write_motions();
  /// The first body beyond all bounds after reading all; -1: none.
  int read_motions();
  void update_joints();
  StepResult diverged(int body, std::string what);
  Pose pose_of(int body) const;
  Twist twist_of(int body) const;
  const StepReport& report() const;
  void forget_report() const;

  SceneModelPtr initial_;
  ShapeData shapes_;
  Progress now_;
  std::vector<Motion> before_;  ///< Progress::motions before the last step
  std::unique_ptr<Engine> engine_;
  bool unchecked_ = true;  ///< motions that no step has left
  mutable StepReport report_;
  mutable bool reported_ = false;
};

}  // namespace cogrsim::ode
