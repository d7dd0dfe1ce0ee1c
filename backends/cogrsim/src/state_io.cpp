// Reading and writing the state of a world, and carrying it over when the scene changes.
#include <algorithm>
#include <cmath>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/scene_state.h"
#include "inelastic_attach.h"
#include "world.h"

namespace cogrsim::dynamics {
namespace {

template <class T>
void copy_entries(const std::vector<T>& from, std::size_t first, int count, std::vector<T>& to) {
  for (std::size_t i = first; i < first + std::size_t(count) && i < from.size(); ++i)
    to[i] = from[i];
}

}  // namespace

void DynamicsWorld::get_state(WorldState& out) const {
  const SceneModel& model = *progress_.model;
  Mechanism& m = engine_->mechanism;
  const Stepper& stepper = engine_->stepper;
  const WorldState& gone = progress_.last_seen;
  const std::vector<LinkMotion>& motions = m.motions();
  out.poses.resize(model.bodies.size());
  out.twists.resize(model.bodies.size());
  out.joint_positions.resize(std::size_t(model.joint_positions));
  out.joint_velocities.resize(std::size_t(model.joint_speeds));
  out.joint_efforts.resize(std::size_t(model.joint_speeds));
  out.motor_efforts.resize(model.motors.size());

  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const int link = m.body_link(int(b));
    if (link >= 0) {
      const LinkMotion& motion = motions[std::size_t(link)];
      out.poses[b] = pose_of(motion.X);
      out.twists[b] = {motion.linear, motion.angular};
    } else if (model.bodies[b].removed && b < gone.poses.size()) {
      out.poses[b] = gone.poses[b];
      out.twists[b] = gone.twists[b];
    } else {
      out.poses[b] = progress_.placed->bodies[b].X_WB;
      out.twists[b] = Twist();
    }
  }

  const double per_step = progress_.last_dt > 0.0 ? 1.0 / progress_.last_dt : 0.0;
  for (std::size_t i = 0; i < out.joint_efforts.size(); ++i)
    out.joint_efforts[i] = per_step * stepper.impulses.joints[i];
  for (std::size_t i = 0; i < out.motor_efforts.size(); ++i)
    out.motor_efforts[i] = per_step * stepper.impulses.motors[i];
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const int link = m.joint_link(int(j));
    if (link >= 0) {
      m.get_joint(m.links()[std::size_t(link)], out.joint_positions.data() + joint.position_offset,
                  out.joint_velocities.data() + joint.speed_offset);
    } else if (joint.removed &&
               gone.joint_positions.size() >=
                   std::size_t(joint.position_offset + position_count(joint.type))) {
      copy_entries(gone.joint_positions, std::size_t(joint.position_offset),
                   position_count(joint.type), out.joint_positions);
      copy_entries(gone.joint_velocities, std::size_t(joint.speed_offset), speed_count(joint.type),
                   out.joint_velocities);
    } else {
      fill_unmoved_joint(joint, out);
    }
  }
}

// Between bodies that no force moves: what their motion makes of it.
void DynamicsWorld::fill_unmoved_joint(const Joint& joint, WorldState& out) const {
  double* const q = out.joint_positions.data() + joint.position_offset;
  // Turns that were counted while it moved stay counted.
  const std::vector<double>& seen = progress_.last_seen.joint_positions;
  const std::size_t first = std::size_t(joint.position_offset);
  const std::size_t count = std::size_t(position_count(joint.type));
  const double* const before =
      first + count <= seen.size() ? seen.data() + first : joint.position.data();
  std::copy_n(before, count, q);
  read_joint(joint, out, q, out.joint_velocities.data() + joint.speed_offset);
}

Result<> DynamicsWorld::set_state(const WorldState& state) {
  const SceneModel& model = *progress_.model;
  if (auto r = check_state(model, state); !r) return r;
  Mechanism& m = engine_->mechanism;
  const Values q = m.state.q(), u = m.state.u();
  try {
    for (const Link& link : m.links()) {
      const std::size_t body = std::size_t(link.plan.body);
      if (link.plan.joint < 0) {
        const Pose X(state.poses[body].p, state.poses[body].q.normalized());
        m.set_base(link, X, state.twists[body]);
        if (link.kinematic) progress_.twists[body] = state.twists[body];
      } else {
        const Joint& joint = model.joints[std::size_t(link.plan.joint)];
        m.set_joint(link, state.joint_positions.data() + joint.position_offset,
                    state.joint_velocities.data() + joint.speed_offset);
      }
    }
    m.project();
  } catch (const std::exception& e) {
    m.state.change_q() = q;
    m.state.change_u() = u;
    return fail(message_of(e));
  }
  engine_->stepper.forget();
  progress_.reactions_kept = false;
  return {};
}

Result<> DynamicsWorld::add(const SceneModelPtr& next) { return rebuild(next, SceneStep::add); }
Result<> DynamicsWorld::remove(const SceneModelPtr& next) {
  return rebuild(next, SceneStep::remove);
}
Result<> DynamicsWorld::change(const SceneModelPtr& next) {
  return rebuild(next, SceneStep::change);
}

SceneModelPtr DynamicsWorld::place_static(const SceneModelPtr& next, const WorldState& now) const {
  const SceneModel& old = *progress_.placed;
  std::shared_ptr<SceneModel> moved;
  for (std::size_t b = 0; b < old.bodies.size(); ++b) {
    const Body& body = next->bodies[b];
    if (body.removed || body.kind != BodyKind::static_body) continue;
    const Pose& X = old.bodies[b].kind == BodyKind::static_body ? old.bodies[b].X_WB : now.poses[b];
    if (X.p == body.X_WB.p && X.q.coeffs() == body.X_WB.q.coeffs()) continue;
    if (!moved) moved = std::make_shared<SceneModel>(*next);
    moved->bodies[b].X_WB = X;
  }
  return moved ? SceneModelPtr(std::move(moved)) : next;
}

Result<> DynamicsWorld::rebuild(const SceneModelPtr& next, SceneStep step) {
  if (!next) return fail("no scene given");
  const auto change = find_scene_change(*progress_.model, *next, step);
  if (!change) return tl::unexpected<Error>(change.error());
  if (auto r = check_parts(*next); !r) return r;
  WorldState before;
  get_state(before);
  const auto pose = [&](int b) { return b < 0 ? Pose() : before.poses[std::size_t(b)]; };
  if (auto r = check_attachments(*next, *change, pose); !r) return r;
  std::vector<Wrench> reactions;
  if (!progress_.model->joints.empty()) get_joint_reactions(reactions);
  reactions.resize(next->joints.size());
  for (std::size_t j = 0; j < next->joints.size(); ++j)
    if (next->joints[j].removed) reactions[j] = {};

  Progress old;
  capture(old);
  std::unique_ptr<Engine> engine;
  bool swapped = false;
  try {
    std::vector<int> stopped;
    for (const int b : change->kinds)
      if (next->bodies[std::size_t(b)].kind == BodyKind::static_body) stopped.push_back(b);
    attach_inelastically(engine_->mechanism, *next, change->attached, stopped);
    get_state(before);
    const SceneModelPtr placed = place_static(next, before);
    engine = std::make_unique<Engine>(placed, options_);
    engine_.swap(engine);
    swapped = true;
    progress_.model = next;
    progress_.placed = placed;
    carry_over(*engine, before);
    const bool other_loops =
        !change->attached.empty() || !change->removed_joints.empty() || !change->kinds.empty();
    if (other_loops && engine_->mechanism.has_loops()) engine_->mechanism.project();
  } catch (const std::exception& e) {
    if (swapped) engine_.swap(engine);
    engine_->mechanism.state.change_u() = old.u;
    progress_ = old;
    return fail(message_of(e));
  }
  progress_.reactions = std::move(reactions);
  progress_.reactions_kept = true;
  return {};
}

void DynamicsWorld::carry_over(const Engine& from, const WorldState& before) {
  Engine& to = *engine_;
  const SceneModel& model = *progress_.model;
  const Mechanism& old = from.mechanism;
  Mechanism& m = to.mechanism;
  const std::size_t old_bodies = before.poses.size();
  const SceneModel& old_model = old.model();
  WorldState seen = before;
  for (std::size_t b = old_bodies; b < model.bodies.size(); ++b) {
    seen.poses.push_back(model.bodies[b].X_WB);
    seen.twists.push_back(model.bodies[b].V_WB);
  }

  const bool carry_udot = from.stepper.memory.udot.size() == old.state.nu();
  Values udot = Values::Zero(m.state.nu());
  std::vector<std::pair<const Link*, const Link*>> same;  // and as it was
  for (const Link& link : m.links()) {
    const std::size_t body = std::size_t(link.plan.body);
    if (body >= old_bodies || old_model.bodies[body].removed) continue;
    // The same joint or base as before: bit for bit.
    const int old_index =
        link.plan.joint >= 0 && std::size_t(link.plan.joint) < old_model.joints.size()
            ? old.joint_link(link.plan.joint)
            : (link.plan.joint < 0 ? old.body_link(int(body)) : -1);
    const Link* const was = old_index < 0 ? nullptr : &old.links()[std::size_t(old_index)];
    if (was && was->plan.joint == link.plan.joint && was->plan.reversed == link.plan.reversed &&
        was->plan.body == link.plan.body) {
      same.emplace_back(&link, was);
      for (int k = 0; k < link.nq; ++k)
        m.state.change_q()[link.first_q + k] = old.state.q()[was->first_q + k];
      for (int k = 0; k < link.nu; ++k) {
        m.state.change_u()[link.first_u + k] = old.state.u()[was->first_u + k];
        if (carry_udot) udot[link.first_u + k] = from.stepper.memory.udot[was->first_u + k];
      }
      continue;
    }
    if (link.plan.joint < 0) {
      m.set_base(link, before.poses[body], before.twists[body]);
      continue;
    }
    const Joint& joint = model.joints[std::size_t(link.plan.joint)];
    if (std::size_t(link.plan.joint) < old_model.joints.size()) {
      m.set_joint(link, before.joint_positions.data() + joint.position_offset,
                  before.joint_velocities.data() + joint.speed_offset);
      continue;
    }
    // A new joint on an old body: its coordinates follow from the bodies' poses.
    double q[7], u[6];
    std::copy(joint.position.begin(), joint.position.end(), q);
    read_joint(joint, seen, q, u);
    m.set_joint(link, q, u);
  }

  // Before the last step; of what is new, as it is.
  if (progress_.start_u.size() == old.state.nu()) {
    Values q = m.state.q(), u = m.state.u();
    for (const auto& [link, was] : same) {
      for (int k = 0; k < link->nq; ++k) q[link->first_q + k] = progress_.start_q[was->first_q + k];
      for (int k = 0; k < link->nu; ++k) u[link->first_u + k] = progress_.start_u[was->first_u + k];
    }
    progress_.start_q = q;
    progress_.start_u = u;
  }

  // Efforts and impulses: the flat arrays only grew.
  Stepper& stepper = to.stepper;
  const Stepper& was = from.stepper;
  copy_entries(was.impulses.joints, 0, old_model.joint_speeds, stepper.impulses.joints);
  copy_entries(was.impulses.motors, 0, int(old_model.motors.size()), stepper.impulses.motors);
  stepper.records = was.records;
  stepper.memory = was.memory;
  stepper.memory.contacts = was.sleep.all_contacts(was.memory);
  stepper.memory.udot = udot;
  stepper.memory.mean_udot.resize(0);
  if (!carry_udot) stepper.memory.had_rows = false;
  if (!was.memory.efforts.empty()) {
    stepper.memory.efforts.assign(std::size_t(RowBuilder::slot_count(model)), 0.0);
    for (int kind = 0; kind <= int(SlotKind::coupling); ++kind) {
      const int count = kind == int(SlotKind::motor)      ? int(old_model.motors.size())
                        : kind == int(SlotKind::coupling) ? int(old_model.couplings.size())
                                                          : old_model.joint_speeds;
      for (int i = 0; i < count; ++i)
        stepper.memory.efforts[std::size_t(RowBuilder::slot_of(model, SlotKind(kind), i))] =
            was.memory.efforts[std::size_t(RowBuilder::slot_of(old_model, SlotKind(kind), i))];
    }
  }

  for (std::size_t b = old_bodies; b < model.bodies.size(); ++b)
    progress_.twists.push_back(model.bodies[b].kind == BodyKind::kinematic ? model.bodies[b].V_WB
                                                                           : Twist());
  progress_.last_seen = before;
}

}  // namespace cogrsim::dynamics
