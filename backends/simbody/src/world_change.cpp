// Changing the scene of a running SimbodyWorld: Simbody's system is built again, and the state carried
// over.
#include <algorithm>
#include <exception>

#include "cogrsim/physics/backend_checks.h"
#include "world.h"

namespace cogrsim::simbody {

Result<> SimbodyWorld::change_to(const SceneModelPtr& next, SceneStep step) {
  if (!next) return fail("no scene given");
  const auto change = find_scene_change(*model_, *next, step);
  if (!change) return tl::unexpected<Error>(change.error());
  if (auto fine = check_parts(*next); !fine) return fine;
  WorldState before;
  get_state(before);
  const auto pose = [&](int b) { return b < 0 ? Pose() : before.poses[b]; };
  // Bodies with an inelastic impact: of a new joint, or made static.
  std::vector<int> inelastic;
  if (auto fits = check_attachments(*next, *change, pose); !fits) return fits;
  for (const int j : change->attached)
    inelastic.insert(inelastic.end(), {next->joints[j].parent, next->joints[j].child});
  for (const int b : change->kinds) {
    before.twists[b] = {};
    for (const Joint& joint : next->joints)
      if (!joint.removed && (joint.parent == b || joint.child == b))
        inelastic.insert(inelastic.end(), {joint.parent, joint.child});
  }
  StepReport report = this->report();
  const std::shared_ptr<Engine> old = engine_;
  const SceneModelPtr old_model = model_;
  const WorldState old_seen = last_seen_;
  stop_integrator();
  const SimTK::State old_state = state_;
  try {
    model_ = next;
    last_seen_ = extended_state(*next, before);
    engine_ = std::make_shared<Engine>(
        next, std::make_shared<const std::vector<Pose>>(last_seen_.poses), options_);
    carry_over(old->mechanism, old_state, inelastic);
  } catch (const std::exception& e) {
    engine_ = old;
    model_ = old_model;
    last_seen_ = old_seen;
    state_ = old_state;
    return fail("Simbody: " + message_of(e));
  }
  report.carry_over(*next);
  held_ = std::move(report);
  stepped_ = false;
  return {};
}

void SimbodyWorld::carry_over(const Mechanism& old, const SimTK::State& old_state,
                              const std::vector<int>& inelastic) {
  const Mechanism& m = engine_->mechanism;
  const SceneModel& was = old.model();
  const WorldState& seen = last_seen_;
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
    if (found && was.bodies[body].kind == model_->bodies[body].kind) {
      for (int k = 0; k < link.nq; ++k) next.updQ()[link.q + k] = old_state.getQ()[found->q + k];
      for (int k = 0; k < link.nu; ++k) next.updU()[link.u + k] = old_state.getU()[found->u + k];
      continue;
    }
    same_loops = false;
    if (link.joint < 0) {
      m.set_base(next, link, seen.poses[body], seen.twists[body]);
      continue;
    }
    const Joint& joint = model_->joints[link.joint];
    double q[7], u[6];
    std::copy_n(seen.joint_positions.data() + joint.position_offset, position_count(joint.type), q);
    read_joint(joint, seen, q, u);
    m.set_joint(next, link, q, u);
  }
  m.set_rates(next);
  if (!inelastic.empty()) take_impact(next, inelastic);
  if (!same_loops && m.has_loops()) m.project(next);
  m.system.realize(next, SimTK::Stage::Velocity);
  state_ = next;
}

void SimbodyWorld::take_impact(SimTK::State& state, const std::vector<int>& inelastic) {
  const Mechanism& m = engine_->mechanism;
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
    const Twist& V = last_seen_.twists[link.body];
    const SimTK::SpatialInertia M = link.mobod.getBodySpatialInertiaInGround(state);
    momenta[link.mobod.getMobilizedBodyIndex()] =
        M * SimTK::SpatialVec(to_simtk(V.angular), to_simtk(V.linear));
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

}  // namespace cogrsim::simbody
