// A running physical world. A backend implements it.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

enum class StepStatus { ok, diverged };

/// How a step ended. A world never pretends: when it failed, its time has not moved on.
struct StepResult {
  StepStatus status = StepStatus::ok;
  int body = -1;        ///< diverged: the first body whose state is not finite or beyond bounds
  std::string message;  ///< diverged: what the engine found
};

/// An opaque, engine-complete copy of a world at one time. Valid for the world it came from, and
/// for any world of the same backend made from the same scene in this process.
class WorldSnapshot {
 public:
  virtual ~WorldSnapshot() = default;
};
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

class World {
 public:
  virtual ~World() = default;

  /// The scene as it is now, with what was added and removed.
  virtual const SceneModelPtr& model() const = 0;

  /// Seconds since the start; the sum of all dt, kept by the caller's step count where it matters.
  virtual double time() const = 0;

  /// Advances by dt [s], > 0. `drives` has one entry per SceneModel::motors (removed ones
  /// ignored). Throws nothing but std::bad_alloc, which leaves a world that is good for nothing but
  /// its destructor; non-finite drives are a caller's bug.
  virtual StepResult step(double dt, const std::vector<Drive>& drives) = 0;

  /// Fills `out`, reusing its memory.
  virtual void get_state(WorldState& out) const = 0;

  /// Moves everything to `state` (efforts ignored) and forgets what contact remembered of the past.
  /// Where bodies are connected by tree joints the joints' coordinates win, with the pose and twist
  /// of each tree's first body. Errors: sizes do not fit, a value is not finite.
  virtual Result<> set_state(const WorldState& state) = 0;

  /// Contacts of the last step, ordered by bodies and shapes; reuses the memory of `out`.
  virtual void get_contacts(std::vector<Contact>& out) const = 0;

  /// Puts into the running world what `next` has beyond model(): everything at the end of its
  /// vectors, at the poses and twists given there; joints also between bodies that are there
  /// already, which they then hold where they are. The state of all else is kept.
  /// Errors: as Backend::create_world; the world is then as it was.
  virtual Result<> add(const SceneModelPtr& next) = 0;

  /// Takes out what is marked `removed` in `next` and was not in model(): bodies with their joints,
  /// or joints alone. The state of all else is kept; what it touched wakes up.
  virtual Result<> remove(const SceneModelPtr& next) = 0;

  /// Takes over what `next` says otherwise of what model() has: Body::kind (dynamic to fixed and
  /// back: the body stops, or starts at rest, where it is) and Joint::axes. The state of all else is
  /// kept. Errors: another difference, or one the engine cannot make; the world is then as it was.
  virtual Result<> change(const SceneModelPtr& next) = 0;

  /// Running on from a restore is bit-identical to having run on from the save.
  virtual SnapshotPtr save() const = 0;
  /// Errors: a snapshot of another backend or scene.
  virtual Result<> restore(const SnapshotPtr& snapshot) = 0;

  /// Back to the scene it was created from, at time 0: equal to a fresh world, bit for bit.
  virtual Result<> reset() = 0;

  /// Optional interfaces by id, nullptr when the engine lacks it: see JointReactions,
  /// KinematicDrive.
  virtual void* extension(std::string_view id) {
    (void)id;
    return nullptr;
  }
};

/// Extension "cogrsim.joint_reactions/1": what each joint transmits.
class JointReactions {
 public:
  static constexpr std::string_view kId = "cogrsim.joint_reactions/1";
  virtual ~JointReactions() = default;
  /// Mean over the last step: force and torque that the parent exerts on the child through the
  /// joint (constraint, motors, springs: all of it), about M's origin, world axes. One per joint;
  /// zero for removed ones.
  virtual void get_joint_reactions(std::vector<Wrench>& out) const = 0;
};

/// Extension "cogrsim.kinematic_drive/1": moves kinematic bodies.
class KinematicDrive {
 public:
  static constexpr std::string_view kId = "cogrsim.kinematic_drive/1";
  virtual ~KinematicDrive() = default;
  /// From the next step on a kinematic body moves with this constant twist (body origin, world
  /// axes).
  virtual Result<> set_kinematic_twist(int body, const Twist& twist) = 0;
};

}  // namespace cogrsim
