// A world of the Bullet backend: the engine with a clock, what it reports, and changes of its scene.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/scene_state.h"
#include "cogrsim/physics/world.h"
#include "engine.h"

namespace cogrsim::bullet {

class BulletWorld final : public World,
                          public JointReactions,
                          public KinematicDrive,
                          public ExternalForces {
 public:
  /// Errors, with the source position: a motor without an axis, a shape or joint Bullet cannot take.
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return engine_->model(); }
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
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces>(this, id);
  }
  void get_joint_reactions(std::vector<Wrench>& out) const override;
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  struct Snapshot;

  BulletWorld(const SceneModelPtr& model, const OptionsPtr& options,
              std::unique_ptr<Engine> engine);
  void start(std::unique_ptr<Engine> engine);
  void forget_report();
  Result<> change_to(const SceneModelPtr& next, SceneStep step);
  StepReport report() const;

  SceneModelPtr initial_;
  OptionsPtr options_;
  std::unique_ptr<Engine> engine_;
  double time_ = 0.0;
  std::vector<Twist> twists_;       // of kinematic bodies, by body
  std::optional<StepReport> held_;  // while Bullet has no step to report
  WorldState gone_;                 // last values of what has been removed
};

}  // namespace cogrsim::bullet
