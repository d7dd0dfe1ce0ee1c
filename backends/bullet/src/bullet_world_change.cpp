// What changes a BulletWorld while it runs: adding, removing, changing what is there.
#include <algorithm>

#include "bullet_world.h"
#include "constraint_group.h"
#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/scene_change.h"

namespace cogrsim::bullet {

namespace {

/// Whose look at the others has to be renewed when joints come or go: one of the two bodies.
void renew_ends(const SceneModel& model, const std::vector<int>& joints,
                const std::vector<RigidBody>& bodies, std::vector<RenewedBody>& out) {
  for (const int j : joints) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    if (joint.bodies_collide || joint.parent == kWorld || joint.child == kWorld) continue;
    const bool child = bodies[static_cast<std::size_t>(joint.child)].kind() != BodyKind::fixed;
    out.push_back({child ? joint.child : joint.parent, btTransform::getIdentity()});
  }
}

}  // namespace

void BulletWorld::keep_reports() {
  std::vector<Wrench> reactions;
  get_joint_reactions(reactions);
  report_.reactions = std::move(reactions);
  reactions_kept_ = true;
  std::vector<Contact> contacts;
  get_contacts(contacts);
  kept_contacts_ = std::move(contacts);
  contacts_kept_ = true;
}

void BulletWorld::measure_attached(const std::vector<int>& joints) {
  const auto pose_of = [&](int body) {
    return body == kWorld ? Pose() : bodies_[static_cast<std::size_t>(body)].pose();
  };
  for (const int j : joints) {
    const Joint& joint = model_->joints[static_cast<std::size_t>(j)];
    joint_position(joint, relative_pose(joint, pose_of(joint.parent), pose_of(joint.child)),
                   joint.position.data(), q_.data() + joint.position_offset);
  }
  q_next_ = q_;
}

void BulletWorld::go_over(const SceneModelPtr& next, const std::vector<GroupPlan>& plans,
                          const std::vector<RenewedBody>& renewed, const std::vector<int>& sudden) {
  collision_->change(next, bodies_, renewed);
  model_ = next;
  build_groups(plans);
  // What no group solves any more transmits nothing from now on.
  std::vector<char> solved(next->joints.size());
  for (const auto& group : groups_) {
    for (const int j : group->joints()) solved[static_cast<std::size_t>(j)] = 1;
  }
  for (std::size_t j = 0; j < next->joints.size(); ++j) {
    if (solved[j]) continue;
    const Joint& joint = next->joints[j];
    report_.reactions[j] = {};
    std::fill_n(report_.joint_efforts.begin() + joint.speed_offset, speed_count(joint.type), 0.0);
  }
  for (std::size_t m = 0; m < next->motors.size(); ++m) {
    if (next->motors[m].removed) report_.motor_efforts[m] = 0.0;
  }
  if (sudden.empty()) return;
  std::vector<char> marks(next->joints.size());
  for (const int j : sudden) marks[static_cast<std::size_t>(j)] = 1;
  for (const auto& group : groups_) {
    const std::vector<int>& joints = group->joints();
    const bool concerned = std::any_of(joints.begin(), joints.end(), [&](int j) {
      return marks[static_cast<std::size_t>(j)] != 0;
    });
    if (concerned) ConstraintGroup(*next, joints, bodies_).join(*next, marks);
  }
}

Result<> BulletWorld::add(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::add);
  if (!change) return tl::unexpected(change.error());
  const auto pose_of = [&](int body) {
    return body == kWorld ? Pose() : bodies_[static_cast<std::size_t>(body)].pose();
  };
  for (const int j : change->attached) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    auto fits = check_attachment(joint, pose_of(joint.parent), pose_of(joint.child));
    if (!fits) return fits;
  }
  if (auto fine = check_motors(*next); !fine) return fine;
  auto plans = plan_groups(*next);
  if (!plans) return tl::unexpected(plans.error());
  keep_reports();
  const std::size_t known = bodies_.size();
  std::vector<RigidBody> grown = std::move(bodies_);
  grown.reserve(next->bodies.size());
  for (std::size_t b = known; b < next->bodies.size(); ++b) {
    grown.emplace_back(next->bodies[b], next->physics.gravity);
  }
  auto added = collision_->add(next, grown, known);
  if (!added) grown.resize(known);
  bodies_ = std::move(grown);
  if (!added) {
    if (const auto same = plan_groups(*model_); same) build_groups(*same);
    return added;
  }
  std::vector<RenewedBody> renewed;
  renew_ends(*next, change->attached, bodies_, renewed);
  go_over(next, *plans, renewed, change->attached);
  measure_attached(change->attached);
  return {};
}

Result<> BulletWorld::remove(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::remove);
  if (!change) return tl::unexpected(change.error());
  auto plans = plan_groups(*next);
  if (!plans) return tl::unexpected(plans.error());
  keep_reports();
  WorldState now;
  get_state(now);
  last_u_ = std::move(now.joint_velocities);
  const auto gone = [&](int body) { return next->bodies[static_cast<std::size_t>(body)].removed; };
  kept_contacts_.erase(
      std::remove_if(kept_contacts_.begin(), kept_contacts_.end(),
                     [&](const Contact& c) { return gone(c.body_a) || gone(c.body_b); }),
      kept_contacts_.end());
  std::vector<RenewedBody> renewed;
  renew_ends(*next, change->removed_joints, bodies_, renewed);
  go_over(next, *plans, renewed, {});
  return {};
}

Result<> BulletWorld::change(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::change);
  if (!change) return tl::unexpected(change.error());
  if (change->kinds.empty()) {
    // Laws of axes are read from the model in each step.
    keep_reports();
    collision_->change(next, bodies_, {});
    model_ = next;
    return {};
  }
  auto plans = plan_groups(*next);
  if (!plans) return tl::unexpected(plans.error());
  keep_reports();
  std::vector<RenewedBody> renewed;
  std::vector<char> stopped(bodies_.size());
  for (const int b : change->kinds) {
    const auto i = static_cast<std::size_t>(b);
    const btTransform X_WP = bodies_[i].object().getWorldTransform();
    RigidBody other = bodies_[i].at_rest(next->bodies[i], next->physics.gravity);
    renewed.push_back({b, other.object().getWorldTransform().inverse() * X_WP});
    bodies_[i] = std::move(other);
    // What starts does so at rest, and has nothing to pass on.
    stopped[i] = bodies_[i].kind() == BodyKind::fixed;
  }
  std::vector<int> sudden;
  for (std::size_t j = 0; j < next->joints.size(); ++j) {
    const Joint& joint = next->joints[j];
    const auto at = [&](int b) { return b != kWorld && stopped[static_cast<std::size_t>(b)] != 0; };
    if (!joint.removed && (at(joint.parent) || at(joint.child)))
      sudden.push_back(static_cast<int>(j));
  }
  go_over(next, *plans, renewed, sudden);
  return {};
}

}  // namespace cogrsim::bullet
