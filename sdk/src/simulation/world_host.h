// The scene of a run and the world that simulates it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/provenance.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

/// Holds the model and the world of one engine, which change together.
class WorldHost {
 public:
  /// Values of the previous step that the world does not have.
  struct Before {
    std::vector<Twist> twists;  ///< empty: not needed
    /// Efforts as in WorldState, if the engine does not have them: after resuming from a file.
    std::vector<double> joint_efforts, motor_efforts;
  };
  /// Part of snapshots.
  struct Saved {
    SceneModelPtr model, original, undrawn;
    SnapshotPtr world;
    Before before;
  };

  /// `scene` has the seed and the step of the run.
  /// `without`: what is left out of it, see leave_out().
  WorldHost(std::shared_ptr<const Backend> backend, Provenance provenance, SceneModelPtr scene,
            std::vector<std::string> without);

  const Backend& backend() const { return *backend_; }
  const Provenance& provenance() const { return provenance_; }
  const SceneModelPtr& model() const { return model_; }        ///< the current scene
  const SceneModelPtr& original() const { return original_; }  ///< the initial scene
  std::uint64_t seed() const { return original_->physics.seed; }
  /// The scene without what this run leaves out.
  SceneModelPtr reduced(SceneModelPtr scene) const {
    return leave_out(std::move(scene), backend_->capabilities(), without_);
  }

  /// Creates the world of the scene.
  Result<> create();
  bool has_world() const { return world_ != nullptr; }
  World& world() { return *world_; }
  const World& world() const { return *world_; }

  /// The initial scene again, optionally with another seed. After an error nothing has changed.
  Result<> restart(std::optional<std::uint64_t> seed);
  /// The world was created from another scene than that of `scene`, from which a restart creates it.
  void restart_from(const WorldHost& scene);

  /// Changes world and model: elements are added, removed, or have other properties.
  Result<> add(SceneModelPtr next);
  Result<> remove(SceneModelPtr next);
  Result<> change(SceneModelPtr next);

  /// The current state; the reference is valid until the next change. Without a world, whose
  /// errors are still being collected, all values are 0.
  const WorldState& state();
  /// As state(), without the cache.
  void get_state(WorldState& out) const;
  /// Must be called after a change of the world through world().
  void changed() { state_fresh_ = false; }

  /// Makes a step from `time` [s] of duration `dt` [s]; `twists` says whether before() gets them.
  StepResult step(double time, double dt, const std::vector<Drive>& drives, bool twists);
  const Before& before() const { return before_; }
  void set_before(Before before) { before_ = std::move(before); }

  Saved save() const { return {model_, original_, undrawn_, world_->save(), before_}; }
  Result<> restore(const Saved& saved);

 private:
  std::shared_ptr<const Backend> backend_;
  Provenance provenance_;
  std::vector<std::string> without_;
  std::unique_ptr<World> world_;
  SceneModelPtr original_, model_;
  SceneModelPtr undrawn_;  // `original_` without drawn values; nullptr: it has none
  bool rebuild_on_restart_ = false;
  WorldState state_;  // cached, valid if `state_fresh_`
  bool state_fresh_ = false;
  Before before_;
};

}  // namespace cogrsim
