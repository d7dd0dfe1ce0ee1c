// State of a SimbodyWorld: reading, writing, saving.
#include <algorithm>
#include <cmath>
#include <exception>

#include "cogrsim/physics/backend_checks.h"
#include "world.h"

namespace cogrsim::simbody {

struct SimbodyWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial, model;
  StaticPoses static_poses;
  SimTK::Vector q, u;
  double engine_time = 0.0, time = 0.0, next_step = 0.0;
  WorldState last_seen;
  StepReport report;
};

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
    double* const q = out.joint_positions.data() + joint.position_offset;
    double* const u = out.joint_velocities.data() + joint.speed_offset;
    const int link = m.joint_link(int(j));
    // Between bodies that no force moves: what their motion makes of it.
    if (link >= 0)
      m.get_joint(now, m.links()[link], q, u);
    else if (!joint.removed)
      read_joint(joint, out, q, u);
  }
  get_efforts(out.joint_efforts, out.motor_efforts);
}

void SimbodyWorld::get_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  joints = held_.joint_efforts;
  motors = held_.motor_efforts;
  if (!stepped_) return;
  joints.resize(efforts_.size());
  std::transform(efforts_.begin(), efforts_.end(), joints.begin(),
                 [&](double impulse) { return impulse / last_dt_; });
  motors.assign(model_->motors.size(), 0.0);
  engine_->drives.get_efforts(state(), joints, motors);
}

Result<> SimbodyWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model_, state); !fine) return fine;
  stop_integrator();
  const SimTK::Vector q = state_.getQ(), u = state_.getU();
  WorldState placed = state;
  for (Pose& X : placed.poses) X.q.normalize();
  try {
    engine_->mechanism.set_all(state_, placed);
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
  out->static_poses = engine_->static_poses;
  out->q = state().getQ();
  out->u = state().getU();
  out->engine_time = state().getTime();
  out->time = time_;
  out->next_step = integrator_ ? integrator_->getPredictedNextStepSize() : next_step_;
  get_state(out->last_seen);
  out->report = report();
  return out;
}

Result<> SimbodyWorld::restore(const SnapshotPtr& snapshot) {
  const auto* saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (!saved) return fail("the snapshot was not made by the simbody backend");
  if (!same_names(*saved->initial, *initial_))
    return fail("the snapshot is of another scene: '" + saved->model->name + "'");
  try {
    if (saved->model != model_ || saved->static_poses != engine_->static_poses)
      engine_ = std::make_shared<Engine>(saved->model, saved->static_poses, options_);
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
  held_ = saved->report;
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
