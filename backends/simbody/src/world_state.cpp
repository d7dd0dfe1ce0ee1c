// State of a SimbodyWorld: reading, writing, saving.
#include <algorithm>
#include <cmath>
#include <exception>

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"
#include "world.h"

namespace cogrsim::simbody {

struct SimbodyWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial, model;
  Places places;
  SimTK::Vector q, u;
  double engine_time = 0.0, time = 0.0, next_step = 0.0;
  WorldState last_seen;
  std::vector<Contact> contacts;
  std::vector<Wrench> reactions;
};

// Between bodies that no force moves: what their motion makes of it, turns counted from `out` on.
void SimbodyWorld::fill_unmoved(const Joint& joint, WorldState& out) const {
  double* const q = out.joint_positions.data() + joint.position_offset;
  const auto pose = [&](int b) { return b < 0 ? Pose() : out.poses[std::size_t(b)]; };
  const auto twist = [&](int b) { return b < 0 ? Twist() : out.twists[std::size_t(b)]; };
  const Pose X_FM = relative_pose(joint, pose(joint.parent), pose(joint.child));
  const std::vector<double> before(q, q + position_count(joint.type));
  joint_position(joint, X_FM, before.data(), q);
  joint_velocity(joint, X_FM,
                 relative_twist(joint, pose(joint.parent), twist(joint.parent), pose(joint.child),
                                twist(joint.child)),
                 q, out.joint_velocities.data() + joint.speed_offset);
}

void SimbodyWorld::get_state(WorldState& out) const {
  const Mechanism& m = engine_->mechanism;
  const SimTK::State& now = state();
  m.system.realize(now, SimTK::Stage::Velocity);
  out = last_seen_;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    if (model_->bodies[b].removed) continue;
    out.poses[b] = m.pose(now, int(b));
    out.twists[b] = m.twist(now, int(b));
  }
  for (std::size_t j = 0; j < model_->joints.size(); ++j) {
    const Joint& joint = model_->joints[j];
    const int link = m.joint_link(int(j));
    if (link >= 0) {
      m.get_joint(now, m.links()[std::size_t(link)],
                  out.joint_positions.data() + joint.position_offset,
                  out.joint_velocities.data() + joint.speed_offset);
    } else if (!joint.removed) {
      fill_unmoved(joint, out);
    }
  }
  if (!stepped_) return;
  std::transform(efforts_.begin(), efforts_.end(), out.joint_efforts.begin(),
                 [&](double impulse) { return impulse / last_dt_; });
  out.motor_efforts.assign(model_->motors.size(), 0.0);
  engine_->drives.get_efforts(now, out.joint_efforts, out.motor_efforts);
}

Result<> SimbodyWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model_, state); !fine) return fine;
  stop_integrator();
  const Mechanism& m = engine_->mechanism;
  const SimTK::Vector q = state_.getQ(), u = state_.getU();
  try {
    for (const Link& link : m.links()) {
      const auto b = std::size_t(link.body);
      if (link.joint < 0) {
        const Pose X(state.poses[b].p, state.poses[b].q.normalized());
        m.set_base(state_, link, X, state.twists[b]);
      } else {
        const Joint& joint = model_->joints[std::size_t(link.joint)];
        m.set_joint(state_, link, state.joint_positions.data() + joint.position_offset,
                    state.joint_velocities.data() + joint.speed_offset);
      }
    }
    m.set_rates(state_);
    m.project(state_);
  } catch (const std::exception& e) {
    state_.updQ() = q;
    state_.updU() = u;
    return fail("Simbody: " + message_of(e));
  }
  next_step_ = 0.0;
  forget_reports();
  return {};
}

SnapshotPtr SimbodyWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->model = model_;
  out->places = engine_->places;
  out->q = state().getQ();
  out->u = state().getU();
  out->engine_time = state().getTime();
  out->time = time_;
  out->next_step = integrator_ ? integrator_->getPredictedNextStepSize() : next_step_;
  get_state(out->last_seen);
  get_contacts(out->contacts);
  get_joint_reactions(out->reactions);
  return out;
}

Result<> SimbodyWorld::restore(const SnapshotPtr& snapshot) {
  const auto* saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (!saved) return fail("the snapshot was not made by the simbody backend");
  if (!same_names(*saved->initial, *initial_))
    return fail("the snapshot is of another scene: '" + saved->model->name + "'");
  try {
    if (saved->model != model_ || saved->places != engine_->places)
      engine_ = std::make_shared<Engine>(saved->model, saved->places, options_);
    integrator_.reset();
    const Mechanism& m = engine_->mechanism;
    state_ = engine_->start;
    state_.updTime() = saved->engine_time;
    state_.updQ() = saved->q;
    state_.updU() = saved->u;
    m.set_rates(state_);
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e));
  }
  model_ = saved->model;
  time_ = saved->time;
  next_step_ = saved->next_step;
  last_seen_ = saved->last_seen;
  held_contacts_ = saved->contacts;
  held_reactions_ = saved->reactions;
  stepped_ = false;
  return {};
}

Result<> SimbodyWorld::reset() {
  try {
    start();
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e));
  }
  return {};
}

}  // namespace cogrsim::simbody
