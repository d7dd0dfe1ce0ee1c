// State of an OdeWorld: reading, writing, saving, changing the scene.
#include <algorithm>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "world.h"

namespace cogrsim::ode {

struct OdeWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial;
  Progress progress;
  std::vector<int> order;  ///< Engine::order()
  Report report;
};

Pose OdeWorld::pose_of(int body) const {
  if (body == kWorld) return {};
  const auto b = static_cast<std::size_t>(body);
  return engine_ && engine_->body(b).exists() ? engine_->body(b).pose() : now_.poses[b];
}

Twist OdeWorld::twist_of(int body) const {
  if (body == kWorld) return {};
  const auto b = static_cast<std::size_t>(body);
  return engine_ && engine_->body(b).exists() ? engine_->body(b).twist() : now_.twists[b];
}

void OdeWorld::get_state(WorldState& out) const {
  const SceneModel& model = *now_.model;
  const std::size_t n = model.bodies.size();
  out.poses.resize(n);
  out.twists.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    out.poses[b] = pose_of(static_cast<int>(b));
    out.twists[b] = twist_of(static_cast<int>(b));
  }
  out.joint_positions = now_.q;
  out.joint_velocities = now_.u;
  if (engine_) {
    std::size_t j = 0;
    for (const JointLink& link : engine_->joints()) {
      const Joint& joint = model.joints[j++];
      if (joint.removed) continue;
      double* const q = out.joint_positions.data() + joint.position_offset;
      link.update(q);
      link.velocities(q, out.joint_velocities.data() + joint.speed_offset);
    }
  }
  out.joint_efforts = report().joint_efforts;
  out.motor_efforts = report().motor_efforts;
}

Result<> OdeWorld::set_state(const WorldState& state) {
  const SceneModel& model = *now_.model;
  if (auto fine = check_state(model, state); !fine) return fine;
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!engine_->body(b).exists()) continue;
    Pose X = state.poses[b];
    X.q.normalize();
    engine_->body(b).set_pose(X);
    engine_->body(b).set_twist(state.twists[b]);
  }
  now_.q = state.joint_positions;
  place_trees(state);
  update_joints();
  (void)read_motions();
  unchecked_ = true;
  engine_->forget_contacts();
  forget_report();
  return {};
}

void OdeWorld::place_trees(const WorldState& state) {
  // Outwards from what no joint moves; a tree that hangs on nothing starts at its first body.
  const SceneModel& model = *now_.model;
  const std::size_t n = model.bodies.size();
  std::vector<char> placed(n);
  for (std::size_t b = 0; b < n; ++b) {
    placed[b] = model.bodies[b].kind != BodyKind::dynamic || model.bodies[b].removed;
  }
  const auto is_placed = [&](int b) { return b == kWorld || placed[static_cast<std::size_t>(b)]; };
  for (std::size_t start = 0; start <= n; ++start) {
    bool spreading = true;
    while (spreading) {
      spreading = false;
      for (const Joint& joint : model.joints) {
        if (joint.removed || joint.closes_loop || joint.type == JointType::free) continue;
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
  BodyLink& body = engine_->body(static_cast<std::size_t>(forward ? joint.child : joint.parent));
  body.set_pose(X_to);
  body.set_twist(V_to);
}

SnapshotPtr OdeWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->progress = now_;
  if (engine_) out->order = engine_->order();
  out->report = report();
  return out;
}

Result<> OdeWorld::restore(const SnapshotPtr& snapshot) {
  const auto* saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (saved == nullptr) return fail("the snapshot was not made by the ode backend");
  const SceneModelPtr& model = saved->progress.model;
  if (model != now_.model && !same_names(*saved->initial, *initial_)) {
    return fail("the snapshot is of another scene: '" + model->name + "'");
  }
  if (model != now_.model || !engine_) {
    if (auto built = rebuild(saved->progress); !built) return built;
  }
  now_ = saved->progress;
  write_motions();
  engine_->set_order(saved->order);
  engine_->forget_contacts();
  report_ = saved->report;
  reported_ = true;
  return {};
}

Result<> OdeWorld::reset() {
  const SceneModelPtr initial = initial_;
  return start(initial);
}

Result<> OdeWorld::add(const SceneModelPtr& next) {
  const auto change = find_scene_change(*now_.model, *next, SceneStep::add);
  if (!change) return tl::unexpected(change.error());
  for (const int j : change->attached) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    auto fits = check_attachment(joint, pose_of(joint.parent), pose_of(joint.child));
    if (!fits) return fits;
  }
  return rebuild_for(next, *change);
}

Result<> OdeWorld::remove(const SceneModelPtr& next) {
  const auto change = find_scene_change(*now_.model, *next, SceneStep::remove);
  if (!change) return tl::unexpected(change.error());
  return rebuild_for(next, *change);
}

Result<> OdeWorld::change(const SceneModelPtr& next) {
  const auto change = find_scene_change(*now_.model, *next, SceneStep::change);
  if (!change) return tl::unexpected(change.error());
  return rebuild_for(next, *change);
}

Result<> OdeWorld::rebuild_for(const SceneModelPtr& next, const SceneChange& change) {
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  WorldState state;
  get_state(state);
  Report report = this->report();
  Progress progress = now_;
  progress.model = next;
  progress.q = state.joint_positions;
  progress.u = state.joint_velocities;
  progress.turned = 0.0;
  for (const int b : change.removed_bodies) {
    progress.poses[static_cast<std::size_t>(b)] = state.poses[static_cast<std::size_t>(b)];
    progress.twists[static_cast<std::size_t>(b)] = state.twists[static_cast<std::size_t>(b)];
  }
  for (std::size_t b = progress.poses.size(); b < next->bodies.size(); ++b) {
    const Body& body = next->bodies[b];
    progress.poses.push_back(body.X_WB);
    progress.twists.push_back(body.kind == BodyKind::fixed ? Twist() : body.V_WB);
  }
  for (std::size_t j = now_.model->joints.size(); j < next->joints.size(); ++j) {
    const Joint& joint = next->joints[j];
    progress.q.insert(progress.q.end(), joint.position.begin(), joint.position.end());
  }
  progress.q.resize(static_cast<std::size_t>(next->joint_positions));
  progress.u.resize(static_cast<std::size_t>(next->joint_speeds), 0.0);
  for (const int b : change.kinds) {
    // It stops where it is, or starts from rest there.
    const auto i = static_cast<std::size_t>(b);
    progress.poses[i] = state.poses[i];
    progress.twists[i] = {};
  }
  if (auto built = rebuild(std::move(progress)); !built) return built;
  for (const int b : change.kinds) {
    BodyLink& body = engine_->body(static_cast<std::size_t>(b));
    if (!body.exists()) continue;
    body.set_pose(now_.poses[static_cast<std::size_t>(b)]);
    body.set_twist({});
    body.read(now_.motions[static_cast<std::size_t>(b)]);
  }
  update_joints();

  // What was reported of what is still there.
  report.joint_efforts.resize(static_cast<std::size_t>(next->joint_speeds), 0.0);
  report.motor_efforts.resize(next->motors.size(), 0.0);
  report.reactions.resize(next->joints.size());
  for (const int j : change.removed_joints) {
    const Joint& joint = next->joints[static_cast<std::size_t>(j)];
    report.reactions[static_cast<std::size_t>(j)] = {};
    std::fill_n(report.joint_efforts.begin() + joint.speed_offset, speed_count(joint.type), 0.0);
  }
  for (std::size_t m = 0; m < next->motors.size(); ++m) {
    if (next->motors[m].removed) report.motor_efforts[m] = 0.0;
  }
  const auto gone = [&](int body) { return next->bodies[static_cast<std::size_t>(body)].removed; };
  report.contacts.erase(
      std::remove_if(report.contacts.begin(), report.contacts.end(),
                     [&](const Contact& c) { return gone(c.body_a) || gone(c.body_b); }),
      report.contacts.end());
  report_ = std::move(report);
  reported_ = true;
  return {};
}

}  // namespace cogrsim::ode
