// A scene running on Bullet.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collision.h"
#include "formulation.h"
#include "grouping.h"
#include "joint_group.h"
#include "rigid_body.h"
#include "solver.h"

#include "cogrsim/physics/world.h"

namespace cogrsim::bullet {

/// Tables of the blocks `<bullet …/>` under `<physics>` and inside an assembly.
const ParameterTable& world_option_table();
const ParameterTable& assembly_option_table();

/// One articulated group and how it is to be solved.
struct GroupPlan {
  JointChain chain;
  bool reduced = false;
};

class BulletWorld final : public World, public JointReactions, public KinematicDrive {
 public:
  /// Errors: bad options, a joint or shape this backend cannot do, with its place.
  static Result<std::unique_ptr<World>> create(const SceneModelPtr& model);

  const SceneModelPtr& model() const override { return model_; }
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
  BulletWorld() = default;

  /// Everything from scratch, as `model` says; its fixed bodies at `anchors` (nbody), if given.
  Result<> build(const SceneModelPtr& model, const std::vector<Pose>* anchors = nullptr);
  /// The formulation of every articulated group of a model; errors: see choose_reduced().
  Result<std::vector<GroupPlan>> plan_groups(const SceneModel& model) const;
  void build_groups(const std::vector<GroupPlan>& plans);
  /// Contacts and reactions of the last step, before what knows them changes.
  void keep_reports();
  /// Collision, groups and reports as `next` has them. `rigid`: bodies that have become others;
  /// `sudden`: joints whose bodies' velocities may not fit them yet, see ConstraintGroup::join.
  void go_over(const SceneModelPtr& next, const std::vector<GroupPlan>& plans,
               const std::vector<RenewedBody>& renewed, const std::vector<int>& sudden);
  /// Coordinates of joints that were attached to bodies where they are.
  void measure_attached(const std::vector<int>& joints);
  std::vector<Pose> anchors() const;
  /// Joint coordinates from the bodies' poses, angles near the last ones.
  void update_joints(std::vector<double>& q) const;
  /// The first body that is not finite or out of bounds; -1: none.
  int find_diverged() const;
  void place_trees(const WorldState& state);
  /// Moves what the solver has given velocities.
  void move_bodies(double dt, std::vector<double>& q);

  SceneModelPtr initial_, model_;
  double time_ = 0.0;
  double last_dt_ = 0.0;
  std::optional<StepSolver> solver_;
  std::vector<RigidBody> bodies_;
  std::unique_ptr<Collision> collision_;
  std::vector<std::unique_ptr<JointGroup>> groups_;
  std::vector<btCollisionObject*> moving_;  ///< dynamic and kinematic, what the solver is given
  std::vector<int> moving_bodies_;
  std::vector<PrincipalState> before_;  ///< of moving_, in case the step fails
  std::vector<double> q_, q_next_;
  std::vector<double> last_u_;  ///< speeds of removed joints stay; the others' mean nothing here
  std::vector<char> counted_by_group_;                  ///< joints, see JointGroup::moves_bodies
  std::vector<char> moved_by_group_;                    ///< bodies
  std::vector<std::pair<btVector3, btVector3>> extra_;  ///< by body, see JointGroup::move
  Formulation formulation_ = Formulation::automatic;
  JointReport report_;
  bool reactions_kept_ = false;  ///< `report_` has them all
  bool contacts_kept_ = false;   ///< `kept_contacts_` are those of the last step
  std::vector<Contact> kept_contacts_;
};

}  // namespace cogrsim::bullet
