#include "engine.h"

#include <algorithm>
#include <cmath>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <limits>

#include "cogrsim/physics/axis_laws.h"

namespace cogrsim::dart_engine {

namespace {

using dart::constraint::PgsBoxedLcpSolver;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kMost = 1e12;        // [N], [N m], [m/s], [rad/s], of what is asked for
constexpr double kSingular = 1e-6;    // of a gimbal: cosine of its second angle
constexpr double kCouplingErp = 0.2;  // part of a coupling's error that a step takes away

std::shared_ptr<PgsBoxedLcpSolver> make_pgs(const Parameters& options) {
  auto out = std::make_shared<PgsBoxedLcpSolver>();
  PgsBoxedLcpSolver::Option it;
  it.mMaxIteration = static_cast<int>(value_of<std::int64_t>(options, "max-iteration"));
  it.mDeltaXThreshold = value_of<double>(options, "delta-x-threshold");
  it.mRelativeDeltaXTolerance = value_of<double>(options, "relative-delta-x-tolerance");
  it.mEpsilonForDivision = value_of<double>(options, "epsilon-for-division");
  out->setOption(it);
  return out;
}

}  // namespace

const ParameterTable& Engine::options() {
  static const ParameterTable table = {
      parameter(
          "lcp-solver", "dantzig",
          "dantzig: DantzigBoxedLcpSolver, by pivoting, and PgsBoxedLcpSolver where that finds "
          "nothing, as DART does; pgs: PgsBoxedLcpSolver, by sweeps")
          .one_of({"dantzig", "pgs"}),
      parameter("max-iteration", 30, "sweeps of PgsBoxedLcpSolver (mMaxIteration)")
          .range(1, 100000),
      parameter("delta-x-threshold", 1e-6, "of its sweeps, the change of an impulse that ends them")
          .range(0.0, 1.0),
      parameter("relative-delta-x-tolerance", 1e-3, "likewise, relative to the impulse")
          .range(0.0, 1.0),
      parameter("epsilon-for-division", 1e-9, "diagonal below which it leaves a row alone")
          .range(0.0, 1.0),
      parameter("max-num-contacts", 10000,
                "contact points of a step; what is beyond DART drops in silence, of 1000 on by its "
                "own default (CollisionOption::maxNumContacts)")
          .range(2, 1000000),
  };
  return table;
}

Result<std::unique_ptr<Engine>> Engine::make(const SceneModelPtr& model, const Parameters& options,
                                             const WorldState& begin, const Engine*) {
  prepare_thread();
  std::unique_ptr<Engine> out(new Engine(model, begin.poses));
  auto detector = Detector::make(*model, out->trees_);
  if (!detector) return tl::unexpected(detector.error());
  out->detector_ = *detector;
  out->world_ = dart::simulation::World::create();
  dart::simulation::World& world = *out->world_;
  using dart::constraint::BoxedLcpConstraintSolver;
  if (value_of<std::string>(options, "lcp-solver") == "pgs")
    world.setConstraintSolver(
        std::make_unique<BoxedLcpConstraintSolver>(make_pgs(options), nullptr));
  else
    world.setConstraintSolver(std::make_unique<BoxedLcpConstraintSolver>(
        std::make_shared<dart::constraint::DantzigBoxedLcpSolver>(), make_pgs(options)));
  world.getConstraintSolver()->setCollisionDetector(out->detector_);
  world.getConstraintSolver()->getCollisionOption().collisionFilter = out->detector_->filter();
  world.getConstraintSolver()->getCollisionOption().maxNumContacts =
      static_cast<std::size_t>(value_of<std::int64_t>(options, "max-num-contacts"));
  world.setGravity(model->physics.gravity);
  world.setTimeStep(model->physics.step);
  for (const auto& skeleton : out->trees_.skeletons()) world.addSkeleton(skeleton);
  for (const auto& weld : out->trees_.welds()) world.getConstraintSolver()->addConstraint(weld);
  for (const Link& link : out->trees_.links()) {
    const Body& body = model->bodies[link.body];
    if (link.kinematic || body.gravity_scale != 1.0) link.node->setGravityMode(false);
  }
  out->add_axes();
  out->add_motors();
  out->add_couplings();
  out->trees_.set_all(begin);
  // What has moved is in front of what has not in ODE's space, which decides the order of contacts and
  // with it the last digits: let it be so from the first step on, as it will be in a restored world.
  for (int i = 0; i < 2 && out->find_lost() < 0; ++i)
    world.getConstraintSolver()->getCollisionGroup()->collide(
        world.getConstraintSolver()->getCollisionOption());
  return out;
}

Engine::RowPtr Engine::add_row(std::vector<AxisRow::Term> terms) {
  auto row = std::make_shared<AxisRow>(std::move(terms));
  world_->getConstraintSolver()->addConstraint(row);
  return row;
}

void Engine::add_ball(int j) {
  const Joint& joint = model_->joints[j];
  dart::dynamics::Joint& it = *trees_.links()[trees_.link_of_joint(j)].joints[0];
  if (joint.axes.empty()) return;
  for (std::size_t i = 0; i < 3; ++i) {
    it.setDampingCoefficient(i, joint.axes[0].damping);
    it.setSpringStiffness(i, joint.axes[0].stiffness);
  }
}

void Engine::add_axes() {
  for (std::size_t j = 0; j < model_->joints.size(); ++j) {
    const Joint& joint = model_->joints[j];
    const int index = trees_.link_of_joint(static_cast<int>(j));
    if (index < 0) continue;
    if (joint.type == JointType::ball) {
      add_ball(static_cast<int>(j));
      continue;
    }
    const Link& link = trees_.links()[index];
    for (std::size_t i = 0; i < joint.axes.size() && joint.type != JointType::fixed; ++i) {
      const JointAxis& axis = joint.axes[i];
      dart::dynamics::Joint& it = *link.joints[i];
      AxisLaw& law = axes_.emplace_back();
      law.joint = static_cast<int>(j);
      law.axis = static_cast<int>(i);
      law.in_dart = &it;
      it.setPositionLowerLimit(0, axis.lower);
      it.setPositionUpperLimit(0, axis.upper);
      it.setLimitEnforcement(axis.has_limit());
      it.setCoulombFriction(0, axis.friction);
      const bool passive = axis.stiffness > 0.0 || axis.damping > 0.0;
      if (axis.rotor_inertia > 0.0) law.rotor = add_row({{&it, 1.0}});
      if (passive && law.rotor) {
        law.passive = add_row({{&it, 1.0}});
      } else if (passive) {
        it.setSpringStiffness(0, axis.stiffness);
        it.setRestPosition(0, axis.rest);
        it.setDampingCoefficient(0, axis.damping);
        law.look = add_row({{&it, 1.0}});
      }
    }
  }
}

void Engine::add_motors() {
  for (std::size_t m = 0; m < model_->motors.size(); ++m) {
    const Motor& motor = model_->motors[m];
    const int index = motor.removed ? -1 : trees_.link_of_joint(motor.joint);
    if (index < 0) continue;
    MotorLaw& law = motors_.emplace_back();
    law.motor = static_cast<int>(m);
    law.joint = trees_.links()[index].joints[motor.axis];
    law.row = add_row({{law.joint, 1.0}});
    // DART's own servo, where its impulse can be told from others of its joint.
    const JointAxis& axis = model_->joints[motor.joint].axes[motor.axis];
    law.servo = motor.mode == MotorMode::velocity && !axis.has_limit() && axis.friction == 0.0 &&
                axis.rotor_inertia == 0.0 && !is_coupled(motor.joint) &&
                motors_of(*model_, motor.joint, motor.axis).size() == 1;
  }
}

bool Engine::is_coupled(int joint) const {
  return std::any_of(
      model_->couplings.begin(), model_->couplings.end(), [&](const Coupling& coupling) {
        return !coupling.removed &&
               (coupling.joint == joint ||
                std::any_of(coupling.terms.begin(), coupling.terms.end(),
                            [&](const CouplingTerm& term) { return term.joint == joint; }));
      });
}

void Engine::add_couplings() {
  for (std::size_t c = 0; c < model_->couplings.size(); ++c) {
    const Coupling& coupling = model_->couplings[c];
    if (coupling.removed) continue;
    CouplingLaw law;
    law.coupling = static_cast<int>(c);
    law.constant = coupling.offset;
    std::vector<AxisRow::Term> terms;
    const auto add = [&](int j, double factor) {
      const int index = trees_.link_of_joint(j);
      if (index >= 0)
        terms.push_back({trees_.links()[index].joints[0], factor});
      else  // what does not move is where it begins
        law.constant -= factor * model_->joints[j].position.at(0);
    };
    add(coupling.joint, 1.0);
    for (const CouplingTerm& term : coupling.terms) add(term.joint, -term.ratio);
    if (terms.empty()) continue;
    law.row = add_row(std::move(terms));
    couplings_.push_back(std::move(law));
  }
}

void Engine::set_motor(MotorLaw& law, const Drive& drive, double h) {
  law.applied = 0.0;
  law.row->clear();
  const double q = law.joint->getPosition(0);
  if (law.servo) {
    using In = dart::dynamics::Joint;
    const auto type = drive.is_speed_source() ? In::SERVO : In::FORCE;
    if (law.joint->getActuatorType() != type) law.joint->setActuatorType(type);
    if (type == In::SERVO) {
      law.joint->setForceLowerLimit(0, -drive.max_effort);
      law.joint->setForceUpperLimit(0, drive.max_effort);
      return law.joint->setCommand(0, drive.velocity);
    }
    law.joint->setForceLowerLimit(0, -kInfinite);
    law.joint->setForceUpperLimit(0, kInfinite);
  }
  if (drive.is_speed_source()) {
    double target = drive.velocity;
    // Two rows without bounds must not want different speeds: DART's own servos stop at limits, too.
    if (drive.max_effort == kInfinite && law.joint->areLimitsEnforced())
      target = std::clamp(target, std::min(0.0, (law.joint->getPositionLowerLimit(0) - q) / h),
                          std::max(0.0, (law.joint->getPositionUpperLimit(0) - q) / h));
    return law.row->set(target, 0.0, drive.max_effort * h);
  }
  const SoftSource soft = at_end_of_step(drive, h, q);
  if (soft.gain > 0.0)
    return law.row->set(soft.speed(), 1.0 / (h * soft.gain), drive.max_effort * h);
  law.applied = std::clamp(drive.bias, -drive.max_effort, drive.max_effort);
  law.joint->setCommand(0, law.joint->getCommand(0) + law.applied);
}

void Engine::set_coupling(std::size_t index, double h) {
  const CouplingLaw& law = couplings_[index];
  double error = -law.constant;
  for (const AxisRow::Term& term : law.row->terms())
    error += term.factor * term.joint->getPosition(0);
  const Coupling& coupling = model_->couplings[law.coupling];
  law.row->set(-kCouplingErp * error / h, 0.0, coupling.max_effort * h);
}

void Engine::set_kinematic(const Link& link, const Twist& V, double h) const {
  // DART integrates the velocity of a free joint with the acceleration of its origin, a + w x v.
  const Mat3 R = link.node->getTransform().linear().transpose();
  const Eigen::Vector6d now = link.joints[0]->getVelocities();
  Eigen::Vector6d wanted;
  wanted << R * V.angular, R * V.linear;
  Eigen::Vector6d a = (wanted - now) / h;
  a.tail<3>() -= now.head<3>().cross(now.tail<3>());
  link.joints[0]->setCommands(a);
}

void Engine::push(const std::vector<Wrench>& external) const {
  for (const Link& link : trees_.links()) {
    const Body& body = model_->bodies[link.body];
    if (link.kinematic) continue;
    Vec3 force = Vec3::Zero();
    if (body.gravity_scale != 1.0)
      force += body.gravity_scale * link.node->getMass() * model_->physics.gravity;
    if (!external.empty() && !link.slave) {
      const Wrench& wrench = external[link.body];
      force += wrench.force;
      if (!wrench.torque.isZero(0.0)) link.node->addExtTorque(wrench.torque, false);
    }
    if (!force.isZero(0.0)) link.node->addExtForce(force, body.com, false, true);
  }
}

void Engine::step(const StepInput& input) {
  const double h = input.dt;
  start_ = state();
  if (find_lost() >= 0) return;
  check_loads(input);
  prepare_thread();
  if (world_->getTimeStep() != h) world_->setTimeStep(h);
  before_.clear();
  for (const Link& link : trees_.links()) before_.push_back(link.node->getTransform());
  for (AxisLaw& law : axes_) {
    const JointAxis& axis = axis_of(law);
    law.q = law.in_dart->getPosition(0);
    if (law.rotor) law.rotor->set(law.in_dart->getVelocity(0), 1.0 / axis.rotor_inertia, kInfinite);
    const double stiff = axis.damping + h * axis.stiffness;
    if (law.passive)
      law.passive->set(axis.stiffness * (axis.rest - law.q) / stiff, 1.0 / (h * stiff), kInfinite);
  }
  for (MotorLaw& law : motors_) set_motor(law, input.drives[law.motor], h);
  for (std::size_t i = 0; i < couplings_.size(); ++i) set_coupling(i, h);
  push(input.external);
  std::vector<Pose> moved_to;
  for (const Link& link : trees_.links()) {
    if (!link.kinematic) continue;
    const Twist& V = input.twists[link.body];
    set_kinematic(link, V, h);
    moved_to.push_back(moved(pose(link.body), V, h));
  }
  world_->step(true);
  std::size_t k = 0;
  for (const Link& link : trees_.links())
    if (link.kinematic) trees_.set_free(link, moved_to[k++], input.twists[link.body]);
  h_ = h;
}

void Engine::forget_step() {
  detector_->forget();
  h_ = 0.0;
}

int Engine::find_lost() const {
  for (const Link& link : trees_.links()) {
    const Twist V = twist(link.body);
    bool fine = StateBounds().hold(link.node->getTransform().translation().squaredNorm(),
                                   V.linear.squaredNorm(), V.angular.squaredNorm());
    for (const dart::dynamics::Joint* joint : link.joints)
      fine = fine && joint->getPositions().allFinite() && joint->getVelocities().allFinite();
    if (link.joint >= 0 && model_->joints[link.joint].type == JointType::gimbal)
      fine = fine && std::abs(std::cos(link.joints[1]->getPosition(0))) > kSingular;
    if (!fine) return link.body;
  }
  return -1;
}

void Engine::check_loads(const StepInput& input) const {
  const auto refuse = [&](int body) {
    throw StepRefused(
        "a load of body '" + model_->bodies[body].name + "' is beyond 1e12 N, N m, m/s", body);
  };
  for (const MotorLaw& law : motors_) {
    const Drive& drive = input.drives[law.motor];
    const double effort = std::min(std::abs(drive.bias), drive.max_effort);
    const bool fast = drive.kd > 0.0 && !(std::abs(drive.velocity) <= kMost);
    const int joint = model_->motors[law.motor].joint;
    if (!(effort <= kMost) || fast) refuse(trees_.links()[trees_.link_of_joint(joint)].body);
  }
  for (std::size_t b = 0; b < input.external.size(); ++b) {
    const Wrench& load = input.external[b];
    if (!(load.force.norm() <= kMost && load.torque.norm() <= kMost)) refuse(static_cast<int>(b));
  }
}

bool Engine::undo() {
  restore(start_);
  return true;
}

Twist Engine::twist(int body) const {
  const dart::dynamics::BodyNode* const node = trees_.node(body);
  return {node->getLinearVelocity(), node->getAngularVelocity()};
}

void Engine::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  if (h_ == 0.0) return;
  const auto at = [&](int joint, int axis) -> double& {
    return joints[model_->joints[joint].speed_offset + axis];
  };
  for (const AxisLaw& law : axes_) {
    // Of the constraints, also DART's for limits and dry friction; inertia is no effort.
    double& effort = at(law.joint, law.axis);
    effort = law.in_dart->getConstraintImpulse(0) / h_;
    if (law.rotor) effort -= law.rotor->impulse() / h_;
    const JointAxis& axis = axis_of(law);
    if (law.look)
      effort -= axis.stiffness * (law.q + h_ * law.look->free_speed() - axis.rest) +
                axis.damping * law.look->free_speed();
  }
  for (const MotorLaw& law : motors_) {
    const Motor& motor = model_->motors[law.motor];
    double impulse = law.row->impulse();
    if (law.joint->getActuatorType() == dart::dynamics::Joint::SERVO)
      impulse = law.joint->getConstraintImpulse(0);
    motors[law.motor] = law.applied + impulse / h_;
    at(motor.joint, motor.axis) += law.applied;
  }
}

void Engine::read_reactions(std::vector<Wrench>& out) const {
  for (std::size_t i = 0; h_ > 0.0 && i < before_.size(); ++i) {
    const Link& link = trees_.links()[i];
    if (link.joint < 0) continue;
    // On the last body of the link, about its frame and in its axes, when the step began.
    const Eigen::Vector6d in_body = link.node->getBodyForce();
    const Mat3 R = before_[i].linear();
    const double sign = link.reversed ? -1.0 : 1.0;
    const Vec3 force = sign * R * in_body.tail<3>(), torque = sign * R * in_body.head<3>();
    const Joint& joint = model_->joints[link.joint];
    Vec3 M = joint.X_CM.p;
    if (!link.reversed) {
      M = before_[i] * M;
    } else if (joint.child == kWorld) {
      (void)M;
    } else if (const int child = trees_.link_of_body(joint.child); child >= 0) {
      M = before_[child] * M;
    } else {
      M = trees_.node(joint.child)->getTransform() * M;
    }
    out[link.joint] = {force, torque + (before_[i].translation() - M).cross(force)};
  }
}

bool Engine::read_joint(int joint, double* q, double* u) const {
  const int link = trees_.link_of_joint(joint);
  if (link >= 0) trees_.get_joint(trees_.links()[link], q, u);
  return link >= 0;
}

Engine::State Engine::state() const {
  State out;
  for (const Link& link : trees_.links()) out.motions.push_back(Trees::motion(link));
  for (const auto& weld : trees_.welds()) out.impulses.push_back(weld->impulses);
  return out;
}

void Engine::restore(const HostedMemory& memory) {
  const auto& state = static_cast<const State&>(memory);
  for (std::size_t i = 0; i < state.motions.size(); ++i)
    Trees::set_motion(trees_.links()[i], state.motions[i]);
  for (std::size_t i = 0; i < state.impulses.size(); ++i)
    trees_.welds()[i]->impulses = state.impulses[i];
  forget_step();
}

void Engine::take_over(const Engine& old, const WorldState& begin, const SceneChange& change) {
  for (const Link& link : trees_.links())
    for (const Link& was : old.trees_.links())
      if (link.same_as(was)) Trees::set_motion(link, Trees::motion(was));
  for (const auto& weld : trees_.welds())
    for (const auto& was : old.trees_.welds())
      if (weld->joint == was->joint) weld->impulses = was->impulses;
  const std::vector<int> struck = struck_bodies(*model_, change);
  if (!struck.empty()) trees_.take_impact(begin, struck);
}

}  // namespace cogrsim::dart_engine
