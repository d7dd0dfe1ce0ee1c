// State of an OdeWorld: reading, writing, saving, changing the scene.
#include <algorithm>

#include "cogrsim/physics/backend_checks.h"
#include "world.h"

namespace cogrsim::ode {

struct OdeWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial;
  Progress progress;
  std::vector<int> order;  ///< Engine::order()
  StepReport report;
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
  if (!model.joints.empty()) report();  // without any there are no efforts to be found
  out.joint_efforts = report_.joint_efforts;
  out.motor_efforts = report_.motor_efforts;
}

Result<> OdeWorld::set_state(const WorldState& state) {
  const SceneModel& model = *now_.model;
  if (auto fine = check_state(model, state); !fine) return fine;
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  WorldState placed = state;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    placed.poses[b].q.normalize();
    if (engine_->body(b).exists()) continue;
    placed.poses[b] = now_.poses[b];
    placed.twists[b] = now_.twists[b];
  }
  place_by_joints(model, placed);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!engine_->body(b).exists()) continue;
    engine_->body(b).set_pose(placed.poses[b]);
    engine_->body(b).set_twist(placed.twists[b]);
  }
  now_.q = state.joint_positions;
  update_joints();
  (void)read_motions();
  unchecked_ = true;
  engine_->forget_contacts();
  forget_report();
  return {};
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
  if (model != now_.model && !same_names(*saved->initial, *initial_))
    return fail("the snapshot is of another scene: '" + model->name + "'");
  if (model != now_.model || !engine_) {
    shapes_ = {};
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

Result<> OdeWorld::change_to(const SceneModelPtr& next, SceneStep step) {
  const auto found = find_scene_change(*now_.model, *next, step);
  if (!found) return tl::unexpected(found.error());
  const SceneChange& change = *found;
  auto fits = check_attachments(*next, change, [&](int b) { return pose_of(b); });
  if (!fits) return fits;
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  WorldState state;
  get_state(state);
  StepReport report = this->report();
  Progress progress = now_;
  progress.model = next;
  progress.q = state.joint_positions;
  progress.u = state.joint_velocities;
  progress.turned = 0.0;
  for (const int b : change.removed_bodies) {
    progress.poses[b] = state.poses[b];
    progress.twists[b] = state.twists[b];
  }
  progress.add_start(now_.model->joints.size());
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
    body.set_pose(now_.poses[b]);
    body.set_twist({});
    body.read(now_.motions[b]);
  }
  update_joints();

  report.carry_over(*next);
  report_ = std::move(report);
  reported_ = true;
  return {};
}

}  // namespace cogrsim::ode
