// A running physical world. Backends implement this interface.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

enum class StepStatus {
  ok,
  diverged,
  fault  ///< the engine itself has failed: the process that it is in has crashed or hung
};

/// Result of a step. After a failed step the time of the world is unchanged.
struct StepResult {
  StepStatus status = StepStatus::ok;
  int body = -1;        ///< diverged: the first body whose state is not finite or out of range
  std::string message;  ///< diverged, fault: description from the engine
};

/// An opaque copy of the complete state of a world, including the internal state of the engine. It
/// is valid for the world it was taken from and for every world of the same backend that was
/// created from the same scene in this process.
class WorldSnapshot {
 public:
  virtual ~WorldSnapshot() = default;
};
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

/// A physical world. Not thread-safe: calls on one world must not overlap, but different worlds may
/// run in different threads at the same time.
class World {
 public:
  virtual ~World() = default;

  /// The current scene, including elements that were added or removed during the run.
  virtual const SceneModelPtr& model() const = 0;

  /// Time since the start [s], the sum of all dt. A caller that needs the exact time counts steps.
  virtual double time() const = 0;

  /// Advances the world by dt [s], > 0. `drives` has one entry per entry of SceneModel::motors;
  /// those of removed motors are ignored, and all values must be finite except where Drive allows
  /// infinity. The only exception thrown is std::bad_alloc; after it the world can only be
  /// destroyed.
  virtual StepResult step(double dt, const std::vector<Drive>& drives) = 0;

  /// Writes the current state to `out`, reusing its memory.
  virtual void get_state(WorldState& out) const = 0;

  /// Sets the state (efforts are ignored) and discards the contact data of earlier steps. In a tree
  /// of joints the joint coordinates and the pose and twist of the first body of the tree determine
  /// the poses of the other bodies. Errors: the sizes do not match, or a value is not finite.
  virtual Result<> set_state(const WorldState& state) = 0;

  /// Writes the contacts of the last step to `out`, ordered by bodies and shapes, reusing its
  /// memory.
  virtual void get_contacts(std::vector<Contact>& out) const = 0;

  /// Adds the elements that `next` has beyond those of model(), at the ends of its vectors, with
  /// the poses and twists given there. New joints may connect bodies that already exist, at their
  /// current poses. The state of all other elements is unchanged. Errors: as
  /// Backend::create_world(); the world is then unchanged.
  virtual Result<> add(const SceneModelPtr& next) = 0;

  /// Removes the elements that are marked `removed` in `next` but not in model(): bodies with their
  /// joints, or joints alone. The state of all other elements is unchanged; sleeping bodies that
  /// touched a removed one wake up. Errors: other differences between the scenes.
  virtual Result<> remove(const SceneModelPtr& next) = 0;

  /// Applies the differences of `next` from model() in Body::kind (dynamic to fixed or back; the
  /// body keeps its pose and has zero velocity) and in Joint::axes. The state of all other elements
  /// is unchanged. Errors: another difference, or one that the engine does not support; the world
  /// is then unchanged.
  virtual Result<> change(const SceneModelPtr& next) = 0;

  /// Saves the complete state. A run that continues from restore() is bit-identical to the run that
  /// continued after save().
  virtual SnapshotPtr save() const = 0;
  /// Restores a saved state. Errors: the snapshot is from another backend or scene.
  virtual Result<> restore(const SnapshotPtr& snapshot) = 0;

  /// Returns to the initial scene at time 0. The world is then bit-identical to a new one.
  virtual Result<> reset() = 0;

  /// An optional interface, or nullptr if the engine does not have it: JointReactions,
  /// ExternalForces, KinematicDrive.
  template <class Interface>
  Interface* extension() {
    return static_cast<Interface*>(extension(Interface::kId));
  }
  /// The same by its id, for engines to implement.
  virtual void* extension(std::string_view id) {
    (void)id;
    return nullptr;
  }
};

/// For World::extension(): the first of the `Interfaces` of a world whose kId is `id`; nullptr: none.
template <class... Interfaces, class Derived>
void* find_extension(Derived* world, std::string_view id) {
  void* found = nullptr;
  static_cast<void>(
      ((id == Interfaces::kId && (found = static_cast<Interfaces*>(world)) != nullptr) || ...));
  return found;
}

/// Extension "cogrsim.joint_reactions/1": the wrench that each joint transmits.
class JointReactions {
 public:
  static constexpr std::string_view kId = "cogrsim.joint_reactions/1";
  virtual ~JointReactions() = default;
  /// Mean force [N] and torque [N m] over the last step that the parent exerts on the child through
  /// the joint, including constraint, motors and springs; about the origin of M, in world axes. One
  /// entry per joint; zero for removed joints.
  virtual void get_joint_reactions(std::vector<Wrench>& out) const = 0;
};

/// Extension "cogrsim.external_forces/1": forces and torques on bodies that the simulation computes.
class ExternalForces {
 public:
  static constexpr std::string_view kId = "cogrsim.external_forces/1";
  virtual ~ExternalForces() = default;
  /// Sets the force [N] through the centre of mass and the torque [N m] of each dynamic body, in
  /// world axes, constant in every following step until set again. One entry per body of model(), or
  /// none at all. They are not part of snapshots. Precondition: all values are finite.
  void set_external_forces(std::vector<Wrench> forces) { external_ = std::move(forces); }
  /// Time after the start of a step at which a force that depends on the state is to be evaluated, as
  /// a fraction of the step: 0 for semi-implicit Euler, 1/2 for methods of second order. A conservative
  /// force then does not change the mean energy.
  virtual double evaluation_time() const { return 0.0; }

 protected:
  std::vector<Wrench> external_;
};

/// Extension "cogrsim.kinematic_drive/1": prescribes the motion of kinematic bodies.
class KinematicDrive {
 public:
  static constexpr std::string_view kId = "cogrsim.kinematic_drive/1";
  virtual ~KinematicDrive() = default;
  /// Sets the constant twist (of the body origin, in world axes) with which a kinematic body moves
  /// from the next step on. Errors: the body is not kinematic, or the twist is not finite.
  virtual Result<> set_kinematic_twist(int body, const Twist& twist) = 0;
};

}  // namespace cogrsim
