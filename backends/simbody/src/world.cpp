#include "world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::simbody {

namespace {

constexpr StateBounds kBounds{1e6, 1e6, 1e6};
constexpr int kMostSteps = 20000;  // of the integrator in one of the world's

// Force of Simbody's stop, see Force::MobilityLinearStop.
double stop_effort(const AxisForces& axis, double d, double q, double u) {
  const double k = axis.stop_stiffness;
  if (q > axis.axis.upper) return std::min(0.0, -k * (q - axis.axis.upper) * (1.0 + d * u));
  if (q < axis.axis.lower) return std::max(0.0, -k * (q - axis.axis.lower) * (1.0 - d * u));
  return 0.0;
}

}  // namespace

SimbodyWorld::Engine::Engine(SceneModelPtr model, StaticPoses poses, const Options& options)
    : scene(model), static_poses(std::move(poses)), mechanism(model, *static_poses, options) {
  const auto& bodies = mechanism.model().bodies;
  const bool touches = std::any_of(bodies.begin(), bodies.end(), [](const Body& body) {
    return !body.removed && body.kind != BodyKind::static_body &&
           std::any_of(body.shapes.begin(), body.shapes.end(),
                       [](const Shape& shape) { return shape.collides; });
  });
  if (touches && options.trackers) {
    trackers = std::make_unique<TrackerContact>(mechanism, options);
  } else if (touches) {
    contact = new GeneralContact(mechanism, options);
    SimTK::Force::Custom(mechanism.forces, contact);
  }
  start = mechanism.realize_topology();
  drives.locate();
}

Result<> SimbodyWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  const auto options = physics_options(*model, "simbody", world_option_table());
  if (!options) return tl::unexpected<Error>(options.error());
  options_ = options_from(*options);
  try {
    engine_ = std::make_shared<Engine>(
        model, std::make_shared<const std::vector<Pose>>(begin.poses), options_);
  } catch (const std::exception& e) {
    return fail("Simbody: " + message_of(e), source_position(*model, model->physics.origin));
  }
  integrator_.reset();
  state_ = engine_->start;
  last_dt_ = next_step_ = 0.0;
  return {};
}

void SimbodyWorld::start_integrator(double dt) {
  integrator_ = make_integrator(options_, engine_->mechanism.system, dt);
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

void SimbodyWorld::stop_integrator() {
  if (!integrator_) return;
  state_ = integrator_->getAdvancedState();
  const double next = integrator_->getPredictedNextStepSize();
  next_step_ = std::isfinite(next) ? next : 0.0;
  integrator_.reset();
}

StepResult SimbodyWorld::advance(double dt, const std::vector<Drive>& drives,
                                 const std::vector<double>&) {
  Engine& engine = *engine_;
  StepResult result;
  if (integrator_ && dt != last_dt_) stop_integrator();
  const SimTK::Vector q = state().getQ(), u = state().getU();
  const double start = state().getTime();
  try {
    if (!integrator_) start_integrator(dt);
    SimTK::State& now = integrator_->updAdvancedState();
    engine.mechanism.system.realize(now, SimTK::Stage::Velocity);
    const bool pushed = !external_.empty() || has_external_forces_;
    if (pushed) engine.mechanism.set_external(now, external_);
    has_external_forces_ = !external_.empty();
    if (!engine.drives.empty()) engine.drives.set(now, dt, drives);
    if (!engine.drives.empty() || pushed) integrator_->reinitialize(SimTK::Stage::Dynamics, false);
    run_integrator(start + dt);
    engine.mechanism.system.realize(state(), SimTK::Stage::Velocity);
    if (const int b = find_diverged(state()); b >= 0) result = diverged(b, kBounds);
  } catch (const std::bad_alloc&) {
    throw;  // no fault of the world's
  } catch (const std::exception& e) {
    // Its integrators put into words whatever was thrown while they start.
    if (std::strstr(e.what(), "std::bad_alloc") != nullptr) throw std::bad_alloc();
    result.message = std::string("Simbody: ") + e.what();
  }
  if (result.message.empty()) {
    last_dt_ = dt;
    return result;
  }
  result.status = StepStatus::diverged;
  if (result.body < 0 && !engine.mechanism.links().empty())
    result.body = engine.mechanism.links().front().body;
  stop_integrator();
  state_.updTime() = start;
  state_.updQ() = q;
  state_.updU() = u;
  next_step_ = 0.0;
  return result;
}

void SimbodyWorld::run_integrator(double end) {
  const auto look = [&]() -> const SimTK::State& {
    const SimTK::State& now = integrator_->getAdvancedState();
    engine_->mechanism.system.realize(now, SimTK::Stage::Velocity);
    read_contacts(now);
    return now;
  };
  efforts_.assign(std::size_t(model()->joint_speeds), 0.0);
  last_efforts_.assign(efforts_.size(), 0.0);
  add_efforts(look(), 0.0);
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
    add_efforts(look(), h);
    contacts_.add(now_, h);
  }
}

void SimbodyWorld::read_contacts(const SimTK::State& state) {
  now_.clear();
  if (engine_->contact) now_ = engine_->contact->read(state);
  if (engine_->trackers) engine_->trackers->read(state, now_);
}

// Of springs, dampers and stops, by the trapezoidal rule over the integrator's own steps.
void SimbodyWorld::add_efforts(const SimTK::State& state, double h) {
  const SimTK::Vector &q = state.getQ(), &u = state.getU();
  for (const AxisForces& axis : engine_->mechanism.axes()) {
    double effort = axis.is_stiff ? 0.0 : -axis.axis.damping * u[axis.u];
    if (axis.axis.stiffness > 0.0) effort -= axis.axis.stiffness * (q[axis.q] - axis.axis.rest);
    if (axis.stops) effort += stop_effort(axis, options_.stop_dissipation, q[axis.q], u[axis.u]);
    double& last = last_efforts_[axis.effort];
    efforts_[axis.effort] += 0.5 * h * (last + effort);
    last = effort;
  }
}

int SimbodyWorld::find_diverged(const SimTK::State& state) const {
  for (const Link& link : engine_->mechanism.links()) {
    const SimTK::Vec3& p = link.mobod.getBodyOriginLocation(state);
    const SimTK::SpatialVec& V = link.mobod.getBodyVelocity(state);
    if (!kBounds.hold(p.normSqr(), V[1].normSqr(), V[0].normSqr())) return link.body;
  }
  return -1;
}

void SimbodyWorld::read_reactions(std::vector<Wrench>& out) const {
  const Mechanism& m = engine_->mechanism;
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
    const Joint& joint = model()->joints[j];
    const Vec3 arm =
        m.pose(state(), joint.parent) * joint.X_PF.p - m.pose(state(), joint.child) * joint.X_CM.p;
    out[j].torque = -(out[j].torque + arm.cross(out[j].force));
    out[j].force = -out[j].force;
  }
}

void SimbodyWorld::move_kinematic(int body) {
  stop_integrator();
  const Mechanism& m = engine_->mechanism;
  const Link& link = m.links()[m.body_link(body)];
  for (int k = 0; k < 3; ++k) {
    state_.updU()[link.u + k] = twists()[body].angular[k];
    state_.updU()[link.u + 3 + k] = twists()[body].linear[k];
  }
  m.set_rates(state_);
}

}  // namespace cogrsim::simbody
