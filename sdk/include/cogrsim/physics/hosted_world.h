// What the worlds of all engines have in common, so that an engine's own is short. For backends.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/coupled_efforts.h"
#include "cogrsim/physics/scene_change.h"
#include "cogrsim/physics/scene_state.h"
#include "cogrsim/physics/warnings.h"
#include "cogrsim/physics/world.h"

namespace cogrsim {

/// Of bodies: beyond these a world has exploded, whatever the numbers say.
struct StateBounds {
  double distance = 1e6;  ///< from the world's origin [m]
  double speed = 1e5;     ///< [m/s]
  double spin = 1e6;      ///< [rad/s]

  /// Of the squares; also false where one is not a number.
  bool hold(double distance_2, double speed_2, double spin_2) const {
    return distance_2 < distance * distance && speed_2 < speed * speed && spin_2 < spin * spin;
  }
};

/// What an engine holds between steps beside the scene; by value, so that any world can take it.
struct HostedMemory {
  virtual ~HostedMemory() = default;
};

/// A World whose engine builds, steps, reads, writes, saves and restores. This class owns the rest:
/// the clock, the last values of removed elements, the twists of kinematic bodies, coordinates of
/// joints where the engine has none, in which turns are counted, the order of contacts, reports while
/// the engine has no step to report, checks of states, twists, snapshots and attached joints, the
/// order of a change, and on request the couplings of joints (see CoupledEfforts).
///
/// An engine implements the protected functions; start() is called once before its world is used.
class COGRSIM_API HostedWorld : public World,
                                public JointReactions,
                                public KinematicDrive,
                                public ExternalForces,
                                public WorldWarnings {
 public:
  /// Builds the world of `model` at time 0. Errors: no model; of check() and build().
  Result<> start(const SceneModelPtr& model);

  const SceneModelPtr& model() const final { return model_; }
  double time() const final { return time_; }
  StepResult step(double dt, const std::vector<Drive>& drives) final;
  void get_state(WorldState& out) const final;
  Result<> set_state(const WorldState& state) final;
  void get_contacts(std::vector<Contact>& out) const final;
  Result<> add(const SceneModelPtr& next) final { return change_to(next, SceneStep::add); }
  Result<> remove(const SceneModelPtr& next) final { return change_to(next, SceneStep::remove); }
  Result<> change(const SceneModelPtr& next) final { return change_to(next, SceneStep::change); }
  SnapshotPtr save() const final;
  Result<> restore(const SnapshotPtr& snapshot) final;
  Result<> reset() final { return start(initial_); }
  void* extension(std::string_view id) override {
    return find_extension<JointReactions, KinematicDrive, ExternalForces, WorldWarnings>(this, id);
  }
  void get_joint_reactions(std::vector<Wrench>& out) const final;
  Result<> set_kinematic_twist(int body, const Twist& twist) final;
  std::vector<Diagnostic> warnings() const override { return {}; }

 protected:
  using MemoryPtr = std::shared_ptr<const HostedMemory>;

  /// Of the backend, as in Backend::name().
  virtual const char* engine_name() const = 0;
  /// Errors: what the engine cannot take, by the model alone; of check_parts().
  virtual Result<> check(const SceneModel& model) const;
  /// Makes the engine's world of `model` in the state `begin`. Errors: the engine is as it was.
  virtual Result<> build(const SceneModelPtr& model, const WorldState& begin) = 0;
  /// The same for the scene that follows a running one, keeping what the engine has of those
  /// elements that stay: contacts, their impulses, last digits. model() is still the old one.
  virtual Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                           const SceneChange& change) {
    (void)change;
    return build(next, begin);
  }
  /// A step of dt [s] with external_ on the bodies and `efforts` [N m], [N] along the joints' speeds
  /// (none, or one per speed), beside what the drives ask for. Diverged: as it was before.
  virtual StepResult advance(double dt, const std::vector<Drive>& drives,
                             const std::vector<double>& efforts) = 0;
  /// Before pose(), twist() and read_joint(), for what an engine puts off until it is asked.
  virtual void prepare_reading() const {}
  // Of a body that is neither static nor removed.
  virtual Pose pose(int body) const = 0;
  virtual Twist twist(int body) const = 0;
  /// Whether the engine has the coordinates of a joint, turns counted. All others are followed: they
  /// are found often enough for each to be the nearest to the one before.
  virtual bool has_coordinates(int joint) const {
    (void)joint;
    return false;
  }
  /// Reads coordinates and speeds of a joint. `q` holds earlier ones. False: this class is to find them
  /// from the motions of its two bodies.
  virtual bool read_joint(int joint, double* q, double* u) const {
    (void)joint, (void)q, (void)u;
    return false;
  }
  /// A bound of what any body turned by in the last step [rad/s]; else followed joints are found in
  /// every step.
  virtual double fastest_spin() const { return std::numeric_limits<double>::infinity(); }
  /// Sets the state; all bodies in trees are where their joints' coordinates place them.
  virtual Result<> write(const WorldState& state) = 0;
  // Of the last step. Efforts: without those that advance() was given. Efforts and reactions are zero
  // on call, and as many as there are in model(). Contacts: in any order, the bodies of each, too.
  virtual void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const = 0;
  virtual void read_contacts(std::vector<Contact>& out) const = 0;
  virtual void read_reactions(std::vector<Wrench>& out) const = 0;
  virtual MemoryPtr save_memory() const = 0;
  /// `memory` is of a world of `model`, whose static bodies are where `begin` has them.
  virtual Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                  const WorldState& begin) = 0;
  /// After a change of twists(), for an engine that does not look there in each step.
  virtual void move_kinematic(int body) { (void)body; }
  /// Whether this class is to find the efforts of couplings.
  virtual bool lacks_couplings() const { return false; }

  /// The state in which the engine's world was last built.
  const WorldState& last() const { return last_; }
  /// By body, of kinematic ones.
  const std::vector<Twist>& twists() const { return twists_; }
  /// Of any body; the engine's own where pose() has it.
  Pose pose_of(int body) const;
  /// Of a followed joint now, for laws within advance().
  const double* coordinates(int joint);
  /// What advance() answers where a body has left the `bounds` of a state: "1000 km, 100 km/s".
  StepResult diverged(int body, const std::string& bounds) const;
  StepResult diverged(int body, const StateBounds& bounds) const;

 private:
  struct Snapshot;
  Result<> change_to(const SceneModelPtr& next, SceneStep step);
  void forget_report() { held_.emplace().clear(*model_); }
  StepReport report() const;
  void take_scene(const SceneModelPtr& model, WorldState state);
  void follow(int joint);
  void count_turns(double dt);
  void efforts(std::vector<double>& joints, std::vector<double>& motors) const;
  void contacts(std::vector<Contact>& out) const;
  void reactions(std::vector<Wrench>& out) const;

  SceneModelPtr initial_, model_;
  double time_ = 0.0;
  WorldState last_;
  std::vector<double> positions_;  // coordinates of followed joints, when they were last found
  std::vector<int> followed_;      // joints
  double turned_ = 0.0;  // bound of what bodies have turned against each other since [rad]
  std::vector<Twist> twists_;
  std::optional<StepReport> held_;  // while the engine has no step to report
  CoupledEfforts couplings_;
};

}  // namespace cogrsim
