// A scene that runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/state_ahead.h"
#include "cogrsim/physics/world.h"
#include "mechanism/reactions.h"
#include "stepper.h"

namespace cogrsim::dynamics {

/// Mechanics, collision detection and stepper of one scene; replaced whole when the scene changes.
struct Engine {
  Engine(SceneModelPtr scene, const StepperOptions& options)
      : mechanism(std::move(scene)),
        detector(mechanism.model()),
        stepper(mechanism, detector, options) {}
  Mechanism mechanism;
  Detector detector;
  Stepper stepper;
};

/// Everything that distinguishes a running world from a fresh one.
struct Progress {
  SceneModelPtr model;
  SceneModelPtr placed;  ///< `model` with its static bodies where they are: what the engine runs
  double time = 0.0;
  double last_dt = 0.0;
  Values q, u;              ///< now
  Values start_q, start_u;  ///< before the last step
  StepMemory memory;
  SleepState sleep;
  EffortSums impulses;
  std::vector<ContactRecord> records;
  std::vector<Twist> twists;  ///< of kinematic bodies (nbody)
  WorldState last_seen;       ///< of what was removed, and of joints that nothing moves
  /// Of the last step, when the scene was changed after it.
  std::vector<Wrench> reactions;
  bool reactions_kept = false;
};

class DynamicsWorld final : public World,
                            public JointReactions,
                            public KinematicDrive,
                            public ExternalForces,
                            public StateAhead {
 public:
  /// Throws std::exception where loops cannot be closed.
  DynamicsWorld(SceneModelPtr model, const StepperOptions& options);

  const SceneModelPtr& model() const override { return progress_.model; }
  double time() const override { return progress_.time; }
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
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces, StateAhead>(this, id);
  }
  double evaluation_time() const override { return 0.5; }
  void get_state_ahead(double ahead, std::vector<Pose>& poses, std::vector<Twist>& twists) override;

  void get_joint_reactions(std::vector<Wrench>& out) const override;
  Result<> set_kinematic_twist(int body, const Twist& twist) override;

 private:
  void start(SceneModelPtr model);
  Result<> rebuild(const SceneModelPtr& next, SceneStep step);
  // `next` with every body that is static in it where it is now; `next` itself where it is so.
  SceneModelPtr place_static(const SceneModelPtr& next, const WorldState& now) const;
  // State of `from` into the engine built for `progress_.placed`.
  void carry_over(const Engine& from, const WorldState& before);
  // Copies what the engine holds beside the model into `progress` and back.
  void capture(Progress& progress) const;
  void apply(const Progress& progress);
  // The first body that is beyond bounds; -1: none.
  int find_diverged() const;
  // Where a step was given up: the first body with a coordinate that is not finite, else the
  // fastest.
  int find_suspect() const;
  void fill_unmoved_joint(const Joint& joint, WorldState& out) const;

  StepperOptions options_;
  bool has_external_forces_ = false;  ///< the mechanism has external forces
  SceneModelPtr initial_;
  std::unique_ptr<Engine> engine_;
  Progress progress_;  ///< q, u, memory, impulses, records live in the engine while it runs
};

}  // namespace cogrsim::dynamics
