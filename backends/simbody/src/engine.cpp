#include "engine.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cogrsim::simbody {

namespace {

constexpr int kMostSteps = 20000;  // of the integrator in one of the world's

// Force of Simbody's stop, see Force::MobilityLinearStop.
double stop_effort(const AxisForces& axis, double d, double q, double u) {
  const double k = axis.stop_stiffness;
  if (q > axis.axis.upper) return std::min(0.0, -k * (q - axis.axis.upper) * (1.0 + d * u));
  if (q < axis.axis.lower) return std::max(0.0, -k * (q - axis.axis.lower) * (1.0 - d * u));
  return 0.0;
}

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

Engine::Engine(const SceneModelPtr& model, const Options& options, const std::vector<Pose>& poses)
    : model_(model), options_(options), mechanism_(model, poses, options) {
  const bool touches =
      std::any_of(model->bodies.begin(), model->bodies.end(), [](const Body& body) {
        return !body.removed && body.kind != BodyKind::static_body &&
               std::any_of(body.shapes.begin(), body.shapes.end(),
                           [](const Shape& shape) { return shape.collides; });
      });
  if (touches && options.trackers) {
    trackers_ = std::make_unique<TrackerContact>(mechanism_, options);
  } else if (touches) {
    contact_ = new GeneralContact(mechanism_, options);
    SimTK::Force::Custom(mechanism_.forces, contact_);
  }
  start_ = state_ = mechanism_.realize_topology();
  drives_.locate();
}

void Engine::start_integrator(double dt) {
  integrator_ = make_integrator(options_, mechanism_.system, dt);
  if (next_step_ > 0.0 && options_.substeps == 0 && integrator_->methodHasErrorControl())
    integrator_->setInitialStepSize(std::min(next_step_, dt));
  try {
    integrator_->initialize(state_);
  } catch (...) {
    integrator_.reset();
    throw;
  }
  if (next_step_ <= 0.0) return;
  // As it was: initializing normalizes and projects what is normal and projected already.
  SimTK::State& advanced = integrator_->updAdvancedState();
  advanced.updQ() = state_.getQ();
  advanced.updU() = state_.getU();
}

void Engine::stop_integrator() {
  if (!integrator_) return;
  state_ = integrator_->getAdvancedState();
  const double next = integrator_->getPredictedNextStepSize();
  next_step_ = std::isfinite(next) ? next : 0.0;
  integrator_.reset();
}

void Engine::step(const StepInput& input) {
  if (integrator_ && input.dt != last_dt_) stop_integrator();
  before_ = {state().getQ(), state().getU(), state().getTime()};
  try {
    if (!integrator_) start_integrator(input.dt);
    SimTK::State& now = integrator_->updAdvancedState();
    mechanism_.system.realize(now, SimTK::Stage::Velocity);
    const bool pushed = !input.external.empty() || has_external_forces_;
    if (pushed) mechanism_.set_external(now, input.external);
    has_external_forces_ = !input.external.empty();
    if (!drives_.empty()) drives_.set(now, input.dt, input.drives);
    if (!drives_.empty() || pushed) integrator_->reinitialize(SimTK::Stage::Dynamics, false);
    run_integrator(before_.time + input.dt);
    mechanism_.system.realize(state(), SimTK::Stage::Velocity);
  } catch (const std::exception& e) {
    // Its integrators put into words whatever was thrown while they start.
    if (std::strstr(e.what(), "bad_alloc") != nullptr) throw std::bad_alloc();
    const bool any = !mechanism_.links().empty();
    throw StepRefused(e.what(), any ? mechanism_.links().front().body : -1);
  }
  last_dt_ = input.dt;
}

bool Engine::undo() {
  stop_integrator();
  put_back(before_);
  next_step_ = 0.0;
  return true;
}

void Engine::put_back(const Coordinates& from) {
  state_.updTime() = from.time;
  state_.updQ() = from.q;
  state_.updU() = from.u;
}

void Engine::run_integrator(double end) {
  efforts_.assign(std::size_t(model_->joint_speeds), 0.0);
  last_efforts_.assign(efforts_.size(), 0.0);
  look(0.0);
  contacts_.start(now_);
  integrator_->setReturnEveryInternalStep(true);
  int steps = 0;
  for (double time = integrator_->getTime(); time < end; time = integrator_->getTime()) {
    integrator_->stepTo(end, end);
    const double h = integrator_->getTime() - time;
    if (h <= 0.0) continue;
    if (++steps > kMostSteps)
      throw std::runtime_error("its integrator wants more than " + std::to_string(kMostSteps) +
                               " steps for one of the world's");
    look(h);
    contacts_.add(now_, h);
  }
}

// Contacts now; of springs, dampers and stops, by the trapezoidal rule over the integrator's own steps.
void Engine::look(double h) {
  const SimTK::State& now = integrator_->getAdvancedState();
  mechanism_.system.realize(now, SimTK::Stage::Velocity);
  if (contact_) now_ = contact_->read(now);
  if (trackers_) trackers_->read(now, now_);
  const SimTK::Vector &q = now.getQ(), &u = now.getU();
  for (const AxisForces& axis : mechanism_.axes()) {
    double effort = axis.is_stiff ? 0.0 : -axis.axis.damping * u[axis.u];
    if (axis.axis.stiffness > 0.0) effort -= axis.axis.stiffness * (q[axis.q] - axis.axis.rest);
    if (axis.stops) effort += stop_effort(axis, options_.stop_dissipation, q[axis.q], u[axis.u]);
    double& last = last_efforts_[axis.effort];
    efforts_[axis.effort] += 0.5 * h * (last + effort);
    last = effort;
  }
}

int Engine::find_lost() const {
  for (const Link& link : mechanism_.links()) {
    const SimTK::Vec3& p = link.mobod.getBodyOriginLocation(state());
    const SimTK::SpatialVec& V = link.mobod.getBodyVelocity(state());
    if (!kBounds.hold(p.normSqr(), V[1].normSqr(), V[0].normSqr())) return link.body;
  }
  return -1;
}

void Engine::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  std::transform(efforts_.begin(), efforts_.end(), joints.begin(),
                 [&](double impulse) { return impulse / last_dt_; });
  drives_.get_efforts(state(), joints, motors);
  mechanism_.add_coupling_efforts(state(), joints);
}

void Engine::read_reactions(std::vector<Wrench>& out) const {
  const Mechanism& m = mechanism_;
  if (out.empty()) return;
  m.system.realize(state(), SimTK::Stage::Acceleration);
  SimTK::Vector_<SimTK::SpatialVec> at_M;
  m.matter.calcMobilizerReactionForces(state(), at_M);
  for (std::size_t j = 0; j < out.size(); ++j) {
    const int index = m.joint_link(int(j));
    if (index < 0) continue;
    const Link& link = m.links()[index];
    const SimTK::SpatialVec& F = at_M[link.mobod.getMobilizedBodyIndex()];
    out[j] = {from_simtk(F[1]), from_simtk(F[0])};
    if (!link.reversed) continue;
    // On the scene's parent, about its frame: the other way round, about the child's.
    const Joint& joint = model_->joints[j];
    const Vec3 arm =
        m.pose(state(), joint.parent) * joint.X_PF.p - m.pose(state(), joint.child) * joint.X_CM.p;
    out[j].torque = -(out[j].torque + arm.cross(out[j].force));
    out[j].force = -out[j].force;
  }
}

void Engine::move_kinematic(int body, const Twist& twist) {
  stop_integrator();
  const Link& link = mechanism_.links()[mechanism_.body_link(body)];
  for (int k = 0; k < 3; ++k) {
    state_.updU()[link.u + k] = twist.angular[k];
    state_.updU()[link.u + 3 + k] = twist.linear[k];
  }
  mechanism_.set_rates(state_);
}

void Engine::take_over(Engine& old, const WorldState& begin, const SceneChange& change) {
  old.stop_integrator();
  next_step_ = old.next_step_;
  last_dt_ = old.last_dt_;
  has_external_forces_ = old.has_external_forces_;
  carry_over(old, begin, struck_bodies(*model_, change));
}

void Engine::carry_over(const Engine& old, const WorldState& seen,
                        const std::vector<int>& inelastic) {
  const Mechanism &m = mechanism_, &was = old.mechanism_;
  state_.updTime() = old.state_.getTime();
  bool same_loops = was.has_loops() == m.has_loops() && inelastic.empty();
  for (const Link& link : m.links()) {
    const auto body = std::size_t(link.body);
    if (body >= was.model().bodies.size()) continue;  // as the scene has it
    // The same mobilizer as before: bit for bit.
    const Link* found = nullptr;
    for (const Link& candidate : was.links())
      if (candidate.body == link.body && candidate.joint == link.joint &&
          candidate.reversed == link.reversed && candidate.slave == link.slave)
        found = &candidate;
    if (found && was.model().bodies[body].kind == m.model().bodies[body].kind) {
      for (int k = 0; k < link.nq; ++k) state_.updQ()[link.q + k] = old.state_.getQ()[found->q + k];
      for (int k = 0; k < link.nu; ++k) state_.updU()[link.u + k] = old.state_.getU()[found->u + k];
      continue;
    }
    same_loops = false;
    if (link.joint < 0) {
      m.set_base(state_, link, seen.poses[body], seen.twists[body]);
      continue;
    }
    const Joint& joint = m.model().joints[link.joint];
    double q[7], u[6];
    std::copy_n(seen.joint_positions.data() + joint.position_offset, position_count(joint.type), q);
    cogrsim::read_joint(joint, seen, q, u);
    m.set_joint(state_, link, q, u);
  }
  m.set_rates(state_);
  m.set_rotors(state_);
  if (!inelastic.empty()) take_impact(m, state_, seen, inelastic);
  if (!same_loops && m.has_loops()) m.project(state_);
  m.system.realize(state_, SimTK::Stage::Velocity);
}

bool Engine::read_joint(int joint, double* q, double* u) const {
  const int link = mechanism_.joint_link(joint);
  if (link >= 0) mechanism_.get_joint(state(), mechanism_.links()[link], q, u);
  return link >= 0;
}

void Engine::write(const WorldState& state) {
  stop_integrator();
  const Coordinates before{state_.getQ(), state_.getU(), state_.getTime()};
  try {
    mechanism_.set_all(state_, state);
  } catch (...) {
    put_back(before);
    throw;
  }
  next_step_ = 0.0;
}

std::shared_ptr<const HostedMemory> Engine::save() const {
  auto out = std::make_shared<Memory>();
  out->coordinates = {state().getQ(), state().getU(), state().getTime()};
  out->next_step = integrator_ ? integrator_->getPredictedNextStepSize() : next_step_;
  return out;
}

void Engine::restore(const HostedMemory& memory) {
  const auto& saved = static_cast<const Memory&>(memory);
  integrator_.reset();
  state_ = start_;
  put_back(saved.coordinates);
  mechanism_.set_rates(state_);
  next_step_ = saved.next_step;
}

}  // namespace cogrsim::simbody
