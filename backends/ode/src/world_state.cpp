// State of an OdeWorld: reading, writing, saving, changing the scene.
#include <algorithm>
#include <cmath>

#include "convert.h"
#include "world.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/scene_change.h"

namespace cogrsim::ode {

/// All there is to know: ODE itself remembers nothing from one step to the next.
struct OdeWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial, model;
  double time = 0.0;
  std::vector<BodyState> bodies;
  std::vector<double> q, last_u, joint_efforts, motor_efforts;
  std::vector<Wrench> reactions;
  std::vector<Contact> contacts;
};

void OdeWorld::get_state(WorldState& out) const {
  const SceneModel& model = *model_;
  out.poses.resize(bodies_.size());
  out.twists.resize(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    out.poses[b] = bodies_[b].pose();
    out.twists[b] = bodies_[b].twist();
  }
  out.joint_positions = q_;
  out.joint_velocities = last_u_;
  out.joint_velocities.resize(static_cast<std::size_t>(model.joint_speeds), 0.0);
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.type == JointType::fixed) continue;
    const Pose X_WP = pose_of(joint.parent), X_WC = pose_of(joint.child);
    joint_velocity(joint, relative_pose(joint, X_WP, X_WC),
                   relative_twist(joint, X_WP, twist_of(joint.parent), X_WC, twist_of(joint.child)),
                   q_.data() + joint.position_offset,
                   out.joint_velocities.data() + joint.speed_offset);
  }
  out.joint_efforts = joint_efforts_;
  out.motor_efforts = motor_efforts_;
}

Result<> OdeWorld::set_state(const WorldState& state) {
  const SceneModel& model = *model_;
  if (auto fine = check_state(*model_, state); !fine) return fine;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].kind == BodyKind::fixed || bodies_[b].removed) continue;
    Pose X = state.poses[b];
    X.q.normalize();
    bodies_[b].set(X, state.twists[b]);
  }
  q_ = state.joint_positions;
  place_trees(state);
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.type == JointType::fixed) continue;
    double previous[7];
    double* q = q_.data() + joint.position_offset;
    std::copy(q, q + position_count(joint.type), previous);
    joint_position(joint, relative_pose(joint, pose_of(joint.parent), pose_of(joint.child)),
                   previous, q);
  }
  std::fill(joint_efforts_.begin(), joint_efforts_.end(), 0.0);
  std::fill(motor_efforts_.begin(), motor_efforts_.end(), 0.0);
  std::fill(reactions_.begin(), reactions_.end(), Wrench{});
  contacts_.clear();
  return {};
}

void OdeWorld::place_trees(const WorldState& state) {
  // Outwards from what no joint moves; a tree that hangs on nothing starts at its first body.
  const SceneModel& model = *model_;
  const std::size_t n = bodies_.size();
  std::vector<char> placed(n);
  for (std::size_t b = 0; b < n; ++b) placed[b] = !bodies_[b].dynamic();
  const auto is_placed = [&](int b) { return b == kWorld || placed[static_cast<std::size_t>(b)]; };
  for (std::size_t start = 0; start <= n; ++start) {
    bool spreading = true;
    while (spreading) {
      spreading = false;
      for (const Joint& joint : model.joints) {
        if (joint.removed || joint.closes_loop) continue;
        const bool forward = is_placed(joint.parent);
        if (forward == is_placed(joint.child)) continue;
        place_across(joint, forward, state);
        placed[static_cast<std::size_t>(forward ? joint.child : joint.parent)] = 1;
        spreading = true;
      }
    }
    if (start < n) placed[start] = 1;
  }
}

void OdeWorld::place_across(const Joint& joint, bool forward, const WorldState& state) {
  const double* q = state.joint_positions.data() + joint.position_offset;
  const double* u = state.joint_velocities.data() + joint.speed_offset;
  const Pose X_FM = joint_pose(joint, q);
  const Twist rel = joint_twist(joint, q, u);  // of M in F, F's axes
  const int from = forward ? joint.parent : joint.child;
  const Pose X = pose_of(from);
  const Twist V = twist_of(from);
  const Pose X_WF = forward ? X * joint.X_PF : X * joint.X_CM * X_FM.inverse();
  const Pose X_WM = X_WF * X_FM;
  const double sign = forward ? 1.0 : -1.0;
  const Vec3 at_M = V.at(X_WM.p - X.p) + sign * (X_WF.q * rel.linear);
  Twist V_to;
  V_to.angular = V.angular + sign * (X_WF.q * rel.angular);
  const Pose X_to = forward ? X_WM * joint.X_CM.inverse() : X_WF * joint.X_PF.inverse();
  V_to.linear = at_M + V_to.angular.cross(X_to.p - X_WM.p);
  bodies_[static_cast<std::size_t>(forward ? joint.child : joint.parent)].set(X_to, V_to);
}

SnapshotPtr OdeWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->model = model_;
  out->time = time_;
  out->bodies = bodies_;
  out->q = q_;
  out->last_u = last_u_;
  out->joint_efforts = joint_efforts_;
  out->motor_efforts = motor_efforts_;
  out->reactions = reactions_;
  out->contacts = contacts_;
  return out;
}

Result<> OdeWorld::restore(const SnapshotPtr& snapshot) {
  const auto* saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (saved == nullptr) return fail("the snapshot was not made by the ode backend");
  if (saved->model != model_) {
    if (!same_names(*saved->initial, *initial_)) {
      return fail("the snapshot is of another scene: '" + saved->model->name + "'");
    }
    if (auto built = build(saved->model, &saved->bodies); !built) return built;
  }
  bodies_ = saved->bodies;
  time_ = saved->time;
  q_ = saved->q;
  last_u_ = saved->last_u;
  joint_efforts_ = saved->joint_efforts;
  motor_efforts_ = saved->motor_efforts;
  reactions_ = saved->reactions;
  contacts_ = saved->contacts;
  return {};
}

Result<> OdeWorld::reset() {
  const SceneModelPtr initial = initial_;
  return build(initial);
}

Result<> OdeWorld::add(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::add);
  if (!change) return tl::unexpected(change.error());
  for (const int j : change->attached) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    auto fits = check_attachment(joint, pose_of(joint.parent), pose_of(joint.child));
    if (!fits) return fits;
  }
  if (auto fine = check_motors(*next); !fine) return fine;
  try {
    if (auto added = collider_->add(*next); !added) return added;
  } catch (const EngineError& error) {
    return fail(std::string(error.what()));
  }
  for (std::size_t b = bodies_.size(); b < next->bodies.size(); ++b) {
    bodies_.emplace_back(next->bodies[b]);
  }
  adopt(next);
  for (const int j : change->attached) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    joint_position(joint, relative_pose(joint, pose_of(joint.parent), pose_of(joint.child)),
                   joint.position.data(), q_.data() + joint.position_offset);
  }
  join(change->attached);
  return {};
}

Result<> OdeWorld::remove(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::remove);
  if (!change) return tl::unexpected(change.error());
  WorldState now;
  get_state(now);
  last_u_ = std::move(now.joint_velocities);
  for (const int b : change->removed_bodies) {
    bodies_[static_cast<std::size_t>(b)].removed = true;
    collider_->remove(b);
  }
  const auto gone = [&](int body) { return next->bodies[static_cast<std::size_t>(body)].removed; };
  contacts_.erase(
      std::remove_if(contacts_.begin(), contacts_.end(),
                     [&](const Contact& c) { return gone(c.body_a) || gone(c.body_b); }),
      contacts_.end());
  for (const int j : change->removed_joints) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    reactions_[static_cast<std::size_t>(j)] = {};
    std::fill_n(joint_efforts_.begin() + joint.speed_offset, speed_count(joint.type), 0.0);
  }
  for (std::size_t m = 0; m < next->motors.size(); ++m) {
    if (next->motors[m].removed) motor_efforts_[m] = 0.0;
  }
  collider_->set_model(*next);
  adopt(next);
  return {};
}

Result<> OdeWorld::change(const SceneModelPtr& next) {
  const auto change = find_scene_change(*model_, *next, SceneStep::change);
  if (!change) return tl::unexpected(change.error());
  std::vector<int> sudden;
  for (const int b : change->kinds) {
    const auto i = static_cast<std::size_t>(b);
    Body body = next->bodies[i];
    body.X_WB = bodies_[i].pose();
    body.V_WB = {};
    bodies_[i] = BodyState(body);
    if (body.kind != BodyKind::fixed) continue;
    for (std::size_t j = 0; j < next->joints.size(); ++j) {
      const Joint& joint = next->joints[j];
      if (joint.removed || (joint.parent != b && joint.child != b)) continue;
      sudden.push_back(static_cast<int>(j));
    }
  }
  collider_->set_model(*next);
  adopt(next);
  join(sudden);
  return {};
}

void OdeWorld::join(const std::vector<int>& sudden) {
  if (sudden.empty()) return;
  const SceneModel& model = *model_;
  std::vector<char> marked(model.joints.size());
  for (const int j : sudden) marked[static_cast<std::size_t>(j)] = 1;
  const double h = 1e-3;  // impulses do not depend on it
  begin_rows();
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.type == JointType::free) continue;
    for (const int b : {joint.parent, joint.child}) {
      if (b != kWorld && ids_[static_cast<std::size_t>(b)])
        solved_[static_cast<std::size_t>(b)] = 1;
    }
  }
  points_.clear();
  put_bodies(h);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const RowBody &parent = row_body(joint.parent), &child = row_body(joint.child);
    if (joint.removed || joint.type == JointType::free || (!parent.id && !child.id)) continue;
    joints_[j].begin(model, static_cast<int>(j), pose_of(joint.parent), pose_of(joint.child),
                     twist_of(joint.parent), twist_of(joint.child),
                     q_.data() + joint.position_offset);
    joints_[j].ask(*rows_, parent, child, marked[j] ? Closing::stop : Closing::keep,
                   pose_of(joint.parent), pose_of(joint.child), h, softness_of(joint));
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (ids_[b]) solved_[b] ? dBodyEnable(ids_[b]) : dBodyDisable(ids_[b]);
  }
  try {
    engine_->step(h);
  } catch (const EngineError&) {
    make_bodies();  // the next step will do it
    return;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!solved_[b]) continue;
    bodies_[b].now.v = to_vec(dBodyGetLinearVel(ids_[b]));
    bodies_[b].now.w = to_vec(dBodyGetAngularVel(ids_[b]));
  }
}

}  // namespace cogrsim::ode
