// State of a BulletWorld: reading, writing, saving.
#include <algorithm>
#include <cmath>

#include "bullet_world.h"
#include "convert.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/scene_change.h"

namespace cogrsim::bullet {

namespace {

class Snapshot final : public WorldSnapshot {
 public:
  SceneModelPtr initial, model;
  double time = 0.0, last_dt = 0.0;
  std::vector<PrincipalState> bodies;
  std::vector<Pose> anchors;  ///< where static bodies are
  std::vector<double> q, last_u;
  JointReport report;
  std::vector<Contact> contacts;
  std::vector<SavedManifold> manifolds;
  std::vector<std::vector<double>> memories;  ///< of the joint groups
};

bool same_elements(const SceneModel& a, const SceneModel& b) {
  if (&a == &b) return true;
  if (a.bodies.size() != b.bodies.size() || a.joints.size() != b.joints.size()) return false;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    if (a.bodies[i].name != b.bodies[i].name || a.bodies[i].removed != b.bodies[i].removed ||
        a.bodies[i].kind != b.bodies[i].kind ||
        a.bodies[i].shapes.size() != b.bodies[i].shapes.size()) {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    const Joint &x = a.joints[i], &y = b.joints[i];
    if (x.name != y.name || x.type != y.type || x.removed != y.removed || x.parent != y.parent ||
        x.child != y.child || !detail::same_axes(x, y)) {
      return false;
    }
  }
  return true;
}

bool same_places(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Pose& x, const Pose& y) {
    return x.p == y.p && x.q.coeffs() == y.q.coeffs();
  });
}

/// Twist of the child when the joint moves as `rel` says (in F's axes, at M's origin).
Twist child_twist(const Twist& V_WP, const Pose& X_WP, const Pose& X_WF, const Pose& X_WM,
                  const Pose& X_WC, const Twist& rel) {
  Twist V;
  V.angular = V_WP.angular + X_WF.q * rel.angular;
  const Vec3 at_M = V_WP.at(X_WM.p - X_WP.p) + X_WF.q * rel.linear;
  V.linear = at_M + V.angular.cross(X_WC.p - X_WM.p);
  return V;
}

}  // namespace

void BulletWorld::get_state(WorldState& out) const {
  const SceneModel& model = *model_;
  const std::size_t n = bodies_.size();
  out.poses.resize(n);
  out.twists.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    out.poses[b] = bodies_[b].pose();
    out.twists[b] = bodies_[b].twist();
  }
  out.joint_positions = q_;
  out.joint_velocities = last_u_;
  out.joint_velocities.resize(static_cast<std::size_t>(model.joint_speeds), 0.0);
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.type == JointType::fixed) continue;
    const auto pose_of = [&](int b) {
      return b == kWorld ? Pose() : out.poses[static_cast<std::size_t>(b)];
    };
    const auto twist_of = [&](int b) {
      return b == kWorld ? Twist() : out.twists[static_cast<std::size_t>(b)];
    };
    const Pose X_WP = pose_of(joint.parent), X_WC = pose_of(joint.child);
    joint_velocity(joint, relative_pose(joint, X_WP, X_WC),
                   relative_twist(joint, X_WP, twist_of(joint.parent), X_WC, twist_of(joint.child)),
                   q_.data() + joint.position_offset,
                   out.joint_velocities.data() + joint.speed_offset);
  }
  out.joint_efforts = report_.joint_efforts;
  out.motor_efforts = report_.motor_efforts;
}

Result<> BulletWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model_, state); !fine) return fine;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].kind() == BodyKind::fixed) continue;
    Pose X = state.poses[b];
    X.q.normalize();
    bodies_[b].set(X, state.twists[b]);
  }
  q_ = state.joint_positions;
  place_trees(state);
  update_joints(q_);
  collision_->clear();
  contacts_kept_ = true;
  kept_contacts_.clear();
  std::fill(report_.joint_efforts.begin(), report_.joint_efforts.end(), 0.0);
  std::fill(report_.motor_efforts.begin(), report_.motor_efforts.end(), 0.0);
  std::fill(report_.reactions.begin(), report_.reactions.end(), Wrench{});
  reactions_kept_ = true;
  for (const auto& group : groups_) group->set_memory({});
  return {};
}

void BulletWorld::place_trees(const WorldState& state) {
  const SceneModel& model = *model_;
  // Placed so far: what no joint moves, then outwards; a tree that hangs on nothing starts at its
  // first body.
  std::vector<char> placed(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) placed[b] = !bodies_[b].dynamic();
  std::vector<std::vector<int>> at_body(bodies_.size());
  std::vector<int> queue;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || joint.closes_loop) continue;
    bool grounded = false;
    for (const int b : {joint.parent, joint.child}) {
      if (b == kWorld || placed[static_cast<std::size_t>(b)]) grounded = true;
      if (b != kWorld) at_body[static_cast<std::size_t>(b)].push_back(static_cast<int>(j));
    }
    if (grounded) queue.push_back(static_cast<int>(j));
  }
  const auto is_placed = [&](int b) { return b == kWorld || placed[static_cast<std::size_t>(b)]; };
  const auto pose_of = [&](int b) {
    return b == kWorld ? Pose() : bodies_[static_cast<std::size_t>(b)].pose();
  };
  const auto twist_of = [&](int b) {
    return b == kWorld ? Twist() : bodies_[static_cast<std::size_t>(b)].twist();
  };
  const auto spread = [&]() {
    for (std::size_t k = 0; k < queue.size(); ++k) {
      const Joint& joint = model.joints[static_cast<std::size_t>(queue[k])];
      const bool forward = is_placed(joint.parent);
      const int target = forward ? joint.child : joint.parent;
      if (is_placed(target)) continue;
      const double* q = state.joint_positions.data() + joint.position_offset;
      const double* u = state.joint_velocities.data() + joint.speed_offset;
      const Pose X_FM = joint_pose(joint, q);
      const Twist rel = joint_twist(joint, q, u);
      Pose X;
      Twist V;
      if (forward) {
        const Pose X_WP = pose_of(joint.parent);
        const Pose X_WF = X_WP * joint.X_PF, X_WM = X_WF * X_FM;
        X = X_WM * joint.X_CM.inverse();
        V = child_twist(twist_of(joint.parent), X_WP, X_WF, X_WM, X, rel);
      } else {
        const Pose X_WC = pose_of(joint.child);
        const Pose X_WM = X_WC * joint.X_CM, X_WF = X_WM * X_FM.inverse();
        X = X_WF * joint.X_PF.inverse();
        const Twist V_WC = twist_of(joint.child);
        V.angular = V_WC.angular - X_WF.q * rel.angular;
        const Vec3 at_M = V_WC.at(X_WM.p - X_WC.p) - X_WF.q * rel.linear;
        V.linear = at_M + V.angular.cross(X.p - X_WM.p);
      }
      bodies_[static_cast<std::size_t>(target)].set(X, V);
      placed[static_cast<std::size_t>(target)] = 1;
      for (const int next : at_body[static_cast<std::size_t>(target)]) queue.push_back(next);
    }
    queue.clear();
  };
  spread();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (placed[b]) continue;
    placed[b] = 1;
    queue = at_body[b];
    spread();
  }
}

std::vector<Pose> BulletWorld::anchors() const {
  std::vector<Pose> out;
  out.reserve(bodies_.size());
  for (const RigidBody& body : bodies_) {
    out.push_back(body.kind() == BodyKind::fixed ? body.anchor() : Pose());
  }
  return out;
}

SnapshotPtr BulletWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->model = model_;
  out->time = time_;
  out->last_dt = last_dt_;
  out->bodies.reserve(bodies_.size());
  for (const RigidBody& body : bodies_) out->bodies.push_back(body.principal());
  out->anchors = anchors();
  out->q = q_;
  out->last_u = last_u_;
  out->report = report_;
  get_joint_reactions(out->report.reactions);
  for (const auto& group : groups_) out->memories.push_back(group->memory());
  get_contacts(out->contacts);
  out->manifolds = collision_->save();
  return out;
}

Result<> BulletWorld::restore(const SnapshotPtr& snapshot) {
  const auto* saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (saved == nullptr) {
    return fail("the snapshot was not made by the bullet backend");
  }
  if (!same_elements(*saved->model, *model_) || !same_places(saved->anchors, anchors())) {
    // The scene has changed since: go back to what it was then.
    if (!same_names(*saved->initial, *initial_)) {
      return fail("the snapshot is of another scene: '" + saved->model->name + "'");
    }
    if (auto built = build(saved->model, &saved->anchors); !built) return built;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) bodies_[b].set_principal(saved->bodies[b]);
  q_ = saved->q;
  last_u_ = saved->last_u;
  report_ = saved->report;
  reactions_kept_ = true;
  for (std::size_t g = 0; g < groups_.size(); ++g) groups_[g]->set_memory(saved->memories[g]);
  time_ = saved->time;
  last_dt_ = saved->last_dt;
  kept_contacts_ = saved->contacts;
  contacts_kept_ = true;
  collision_->restore(saved->manifolds, bodies_);
  return {};
}

Result<> BulletWorld::reset() {
  const SceneModelPtr initial = initial_;
  return build(initial);
}

}  // namespace cogrsim::bullet
