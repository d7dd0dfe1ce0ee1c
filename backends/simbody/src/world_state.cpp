// State of a SimbodyWorld: reading, writing, saving, and carrying it over to the next scene, for which
// Simbody's system is built again.
#include <algorithm>
#include <exception>

#include "world.h"

namespace cogrsim::simbody {

namespace {

void take_impact(const Mechanism& m, SimTK::State& state, const WorldState& seen,
                 const std::vector<int>& inelastic) {
  if (state.getNU() == 0) return;
  std::vector<char> touched(m.links().size());  // by tree
  for (const int b : inelastic)
    if (m.body_link(b) >= 0) touched[m.links()[m.body_link(b)].tree] = 1;
  m.system.realize(state, SimTK::Stage::Position);
  // A plastic impact: of all velocities that the joints allow those with the momentum there was,
  // M u = sum J^T (momentum), by Simbody's M and J.
  SimTK::Vector_<SimTK::SpatialVec> momenta(m.matter.getNumBodies(),
                                            SimTK::SpatialVec(SimTK::Vec3(0)));
  for (const Link& link : m.links()) {
    const Twist& V = seen.twists[link.body];
    const SimTK::SpatialInertia M = link.mobod.getBodySpatialInertiaInGround(state);
    momenta[link.mobod.getMobilizedBodyIndex()] =
        M * SimTK::SpatialVec(to_simtk(V.angular), to_simtk(V.linear));
  }
  for (const Rotor& rotor : m.rotors()) {
    const double momentum = rotor.inertia * state.getU()[rotor.u];
    momenta[rotor.pin.getMobilizedBodyIndex()] =
        SimTK::SpatialVec(SimTK::Vec3(0, 0, momentum), SimTK::Vec3(0));
  }
  SimTK::Vector f, u;
  m.matter.multiplyBySystemJacobianTranspose(state, momenta, f);
  m.matter.multiplyByMInv(state, f, u);
  const SimTK::Vector old_u = state.getU();
  for (const Link& link : m.links())
    for (int k = 0; k < link.nu && touched[link.tree] && !link.kinematic; ++k)
      state.updU()[link.u + k] = u[link.u + k];
  if (!m.has_loops()) return;
  m.system.realize(state, SimTK::Stage::Velocity);
  const SimTK::Vector error = -state.getUErr();
  if (error.size() == 0) return;
  SimTK::Vector impulse;
  m.matter.solveForConstraintImpulses(state, error, impulse);
  m.matter.multiplyByGTranspose(state, impulse, f);
  m.matter.multiplyByMInv(state, f, u);
  state.updU() += u;
}

}  // namespace

Result<> SimbodyWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                               const SceneChange& change) {
  const std::vector<int> inelastic = struck_bodies(*next, change);
  const std::shared_ptr<Engine> old = engine_;
  stop_integrator();
  try {
    engine_ = std::make_shared<Engine>(next, std::make_shared<const std::vector<Pose>>(begin.poses),
                                       options_);
    state_ = carried_over(old->mechanism, begin, inelastic);
  } catch (const std::exception& e) {
    engine_ = old;
    return fail("Simbody: " + message_of(e));
  }
  return {};
}

SimTK::State SimbodyWorld::carried_over(const Mechanism& old, const WorldState& seen,
                                        const std::vector<int>& inelastic) const {
  const Mechanism& m = engine_->mechanism;
  const SceneModel& was = old.model();
  const SimTK::State& old_state = state_;
  SimTK::State next = engine_->start;
  next.updTime() = old_state.getTime();
  bool same_loops = old.has_loops() == m.has_loops() && inelastic.empty();
  for (const Link& link : m.links()) {
    const auto body = std::size_t(link.body);
    if (body >= was.bodies.size()) continue;  // as the scene has it
    // The same mobilizer as before: bit for bit.
    const Link* found = nullptr;
    for (const Link& candidate : old.links())
      if (candidate.body == link.body && candidate.joint == link.joint &&
          candidate.reversed == link.reversed && candidate.slave == link.slave)
        found = &candidate;
    if (found && was.bodies[body].kind == m.model().bodies[body].kind) {
      for (int k = 0; k < link.nq; ++k) next.updQ()[link.q + k] = old_state.getQ()[found->q + k];
      for (int k = 0; k < link.nu; ++k) next.updU()[link.u + k] = old_state.getU()[found->u + k];
      continue;
    }
    same_loops = false;
    if (link.joint < 0) {
      m.set_base(next, link, seen.poses[body], seen.twists[body]);
      continue;
    }
    const Joint& joint = m.model().joints[link.joint];
    double q[7], u[6];
    std::copy_n(seen.joint_positions.data() + joint.position_offset, position_count(joint.type), q);
    cogrsim::read_joint(joint, seen, q, u);
    m.set_joint(next, link, q, u);
  }
  m.set_rates(next);
  m.set_rotors(next);
  if (!inelastic.empty()) take_impact(m, next, seen, inelastic);
  if (!same_loops && m.has_loops()) m.project(next);
  m.system.realize(next, SimTK::Stage::Velocity);
  return next;
}

bool SimbodyWorld::read_joint(int joint, double* q, double* u) const {
  const Mechanism& m = engine_->mechanism;
  const int link = m.joint_link(joint);
  if (link >= 0) m.get_joint(state(), m.links()[link], q, u);
  return link >= 0;
}

void SimbodyWorld::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  std::transform(efforts_.begin(), efforts_.end(), joints.begin(),
                 [&](double impulse) { return impulse / last_dt_; });
  engine_->drives.get_efforts(state(), joints, motors);
  engine_->mechanism.add_coupling_efforts(state(), joints);
}

Result<> SimbodyWorld::write(const WorldState& state) {
  stop_integrator();
  const SimTK::Vector q = state_.getQ(), u = state_.getU();
  try {
    engine_->mechanism.set_all(state_, state);
  } catch (const std::exception& e) {
    state_.updQ() = q;
    state_.updU() = u;
    return fail("Simbody: " + message_of(e));
  }
  next_step_ = 0.0;
  return {};
}

HostedWorld::MemoryPtr SimbodyWorld::save_memory() const {
  auto out = std::make_shared<Saved>();
  out->static_poses = engine_->static_poses;
  out->q = state().getQ();
  out->u = state().getU();
  out->time = state().getTime();
  out->next_step = integrator_ ? integrator_->getPredictedNextStepSize() : next_step_;
  return out;
}

Result<> SimbodyWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                      const WorldState&) {
  const auto& saved = static_cast<const Saved&>(*memory);
  try {
    if (model != engine_->scene || saved.static_poses != engine_->static_poses)
      engine_ = std::make_shared<Engine>(model, saved.static_poses, options_);
    integrator_.reset();
    state_ = engine_->start;
    state_.updTime() = saved.time;
    state_.updQ() = saved.q;
    state_.updU() = saved.u;
    engine_->mechanism.set_rates(state_);
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e));
  }
  next_step_ = saved.next_step;
  return {};
}

}  // namespace cogrsim::simbody
