// A running world on Simbody.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contact.h"
#include "drives.h"
#include "mechanism.h"
#include "trackers.h"

#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/scene_state.h"
#include "cogrsim/physics/world.h"

namespace cogrsim::simbody {

class SimbodyWorld final : public World,
                           public JointReactions,
                           public KinematicDrive,
                           public ExternalForces {
 public:
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return model_; }
  double time() const override { return time_; }
  StepResult step(double dt, const std::vector<Drive>& drives) override;
  void get_state(WorldState& out) const override;
  Result<> set_state(const WorldState& state) override;
  void get_contacts(std::vector<Contact>& out) const override {
    out = stepped_ ? contacts_.get(last_dt_) : held_.contacts;
  }
  Result<> add(const SceneModelPtr& next) override { return change_to(next, SceneStep::add); }
  Result<> remove(const SceneModelPtr& next) override { return change_to(next, SceneStep::remove); }
  Result<> change(const SceneModelPtr& next) override { return change_to(next, SceneStep::change); }
  SnapshotPtr save() const override;
  Result<> restore(const SnapshotPtr& snapshot) override;
  Result<> reset() override;
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces>(this, id);
  }
  double evaluation_time() const override { return 0.5; }
  void get_joint_reactions(std::vector<Wrench>& out) const override {
    out = stepped_ ? find_reactions() : held_.reactions;
  }
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  bool has_external_forces_ = false;  ///< the state has external forces
  struct Snapshot;
  using StaticPoses = std::shared_ptr<const std::vector<Pose>>;  ///< of static bodies, by body
  /// Simbody's system with all that was added to it. It stays where it is: the system refers to it.
  struct Engine {
    Engine(SceneModelPtr model, StaticPoses poses, const Options& options);
    StaticPoses static_poses;
    Mechanism mechanism;
    Drives drives{mechanism};
    GeneralContact* contact = nullptr;  ///< owned by the force subsystem
    std::unique_ptr<TrackerContact> trackers;
    SimTK::State start;
  };
  SimbodyWorld(SceneModelPtr model, const Options& options);
  void start();
  void start_integrator(double dt);
  void stop_integrator();
  const SimTK::State& state() const {
    return integrator_ ? integrator_->getAdvancedState() : state_;
  }

  void run_integrator(double end);
  void read_contacts(const SimTK::State& state);
  void add_efforts(const SimTK::State& state, double h);
  int find_diverged(const SimTK::State& state) const;
  void forget_reports();
  std::vector<Wrench> find_reactions() const;
  void get_efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  StepReport report() const;

  Result<> change_to(const SceneModelPtr& next, SceneStep step);
  void carry_over(const Mechanism& old, const SimTK::State& old_state,
                  const std::vector<int>& inelastic);
  void take_impact(SimTK::State& state, const std::vector<int>& inelastic);

  SceneModelPtr initial_, model_;
  StaticPoses initial_static_poses_;
  Options options_;
  std::shared_ptr<Engine> engine_;
  std::unique_ptr<SimTK::Integrator> integrator_;  ///< none: before the first step, after changes
  SimTK::State state_;                             ///< while there is no integrator
  double next_step_ = 0.0;  ///< of the integrator that is to come [s]; 0: as Simbody has it
  double time_ = 0.0, last_dt_ = 0.0;
  ContactReport contacts_;
  std::vector<Contact> now_;
  std::vector<double> efforts_, last_efforts_;  ///< of springs, dampers, stops: impulses, at a time
  bool stepped_ = false;                        ///< the engine has what the last step found
  StepReport held_;                             ///< while it does not
  /// At the last change of the scene: what is gone, and turns of joints that hold nothing.
  WorldState last_seen_;
};

}  // namespace cogrsim::simbody
