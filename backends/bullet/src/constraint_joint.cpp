#include "constraint_joint.h"

#include <utility>

#include <BulletDynamics/ConstraintSolver/btFixedConstraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/axis_laws.h"
#include "convert.h"

namespace cogrsim::bullet {

namespace {

void enable(btGeneric6DofConstraint& constraint, int dof, bool on) {
  (dof < 3 ? constraint.getTranslationalLimitMotor()->m_enableMotor[dof]
           : constraint.getRotationalLimitMotor(dof - 3)->m_enableMotor) = on;
}

constexpr double kUnbounded = 1e30;  // Bullet adds to and multiplies its bounds

/// s of apply_law() from which a law is a motor of Bullet's. Its sequential impulses converge for
/// softnesses 1 / s below 1, by 1 / s per sweep: 3 % are left after 10.
constexpr double kStiff = 1.4;

/// The same where efforts of couplings are found on the assumption that laws hold at the end of the
/// step: what is below is the same to 1 %.
constexpr double kSoft = 0.01;

constexpr double kWidestLimits = 6.2;  // that Bullet's angles tell from each other [rad]
constexpr double kNear = 1.5;          // stops farther from the joint are not given to Bullet [rad]

/// A speed source beside a rotor: as stiff as that it leaves a thousandth of what disturbs it.
constexpr double kSource = 1e3;
/// Below this share of its bound a stiff law beside a rotor has no bound.
constexpr double kFarFromBound = 0.5;

/// Whether the farthest limit of an angle is out of Bullet's reach, from the other or the start.
bool is_wide(const JointAxis& axis, double start) {
  return !(std::max({axis.upper - axis.lower, axis.upper - start, start - axis.lower}) <=
           kWidestLimits);
}

}  // namespace

ConstraintJoint::ConstraintJoint(const SceneModel& model, int joint, btRigidBody& a, btRigidBody& b,
                                 const btTransform& frame_a, const btTransform& frame_b,
                                 double softness)
    : joint_(joint),
      first_speed_(model.joints[joint].speed_offset),
      type_(model.joints[joint].type),
      a_(a),
      b_(b),
      frame_a_(frame_a),
      frame_b_(frame_b),
      softness_(softness),
      collide_(model.joints[joint].bodies_collide) {}

void ConstraintJoint::make_constraint() {
  switch (type_) {
    case JointType::hinge:
      main_ = std::make_unique<btHingeConstraint>(a_, b_, frame_a_, frame_b_, true);
      break;
    case JointType::ball:
      main_ = std::make_unique<btPoint2PointConstraint>(a_, b_, frame_a_.getOrigin(),
                                                        frame_b_.getOrigin());
      break;
    case JointType::fixed:
      main_ = std::make_unique<btFixedConstraint>(a_, b_, frame_a_, frame_b_);
      break;
    default:
      main_ = make_six();
  }
}

void ConstraintJoint::make_laws(const SceneModel& model) {
  main_->setUserConstraintPtr(&load_);
  make_axes(model.joints[joint_]);
  make_rows(model);
  if (auto* six = dynamic_cast<btGeneric6DofConstraint*>(main_.get())) {
    for (int dof = 0; dof < 6; ++dof) six->setLimit(dof, 0.0, 0.0);
    for (const Axis& axis : axes_) six->setLimit(axis.dof, 1.0, -1.0);
  }
  set_limits();
}

void ConstraintJoint::make_axes(const Joint& joint) {
  for (int i = 0; i < speed_count(type_); ++i) {
    Axis& axis = axes_.emplace_back();
    const bool universal = type_ == JointType::universal;
    axis.on_child = universal && i == 1;
    axis.angular = axis_turns(type_, i);
    const btVector3 along = to_bt(axis_direction(type_, i));
    axis.dof = along.maxAxis() + (axis.angular ? 3 : 0);
    if (universal) axis.dof = i == 0 ? 5 : 3;  // see make_six()
    axis.direction = (axis.on_child ? frame_b_ : frame_a_).getBasis().getColumn(along.maxAxis());
    if (!joint.axes.empty()) axis.law = axis_of_speed(joint, i);
    const double start = at(i) < joint.position.size() ? joint.position[i] : 0.0;
    axis.wide = axis.angular && axis.law.has_limit() && is_wide(axis.law, start);
  }
}

void ConstraintJoint::make_rows(const SceneModel& model) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    // The main constraint's motor, if it has one. A stop would share its row, and its bound.
    bool taken = axis.law.has_limit() || type_ == JointType::ball;
    const auto add = [&](Kind kind, int motor) {
      Row row;
      row.kind = kind;
      row.motor = motor;
      if (taken) row.extra = make_extra();
      taken = true;
      axis.rows.push_back(row);
    };
    for (const int m : motors_of(model, joint_, static_cast<int>(i))) add(Kind::motor, m);
    if (axis.law.friction > 0.0) add(Kind::friction, -1);
    if (axis.law.stiffness > 0.0 || axis.law.damping > 0.0) add(Kind::passive, -1);
    if (axis.law.rotor_inertia > 0.0) add(Kind::rotor, -1);
    has_laws_ |= !axis.rows.empty() || axis.wide;
  }
}

std::unique_ptr<btGeneric6DofConstraint> ConstraintJoint::make_six() const {
  // It measures x on B, z on A, and y, across them, within a quarter turn only: what may turn must
  // be one of the others, and the first axis of a universal joint its z.
  btTransform turn = btTransform::getIdentity();
  if (type_ == JointType::universal) turn.setBasis({0, 0, 1, 1, 0, 0, 0, 1, 0});
  auto made =
      std::make_unique<btGeneric6DofConstraint>(a_, b_, frame_a_ * turn, frame_b_ * turn, true);
  // Otherwise the two ends of a slider that is out are pushed apart with a couple that nothing holds.
  made->setUseFrameOffset(false);
  return made;
}

ConstraintJoint::Extra* ConstraintJoint::make_extra() {
  auto extra = std::make_unique<Extra>();
  extra->constraint = make_six();
  for (int dof = 0; dof < 6; ++dof) extra->constraint->setLimit(dof, 1.0, -1.0);
  extra->constraint->setUserConstraintPtr(&extra->load);
  extras_.push_back(std::move(extra));
  return extras_.back().get();
}

void ConstraintJoint::set_limits() {
  for (const Axis& axis : axes_) {
    if (!axis.law.has_limit() || axis.wide) continue;
    if (axis.angular) {
      set_limits(axis, axis.law.lower, axis.law.upper);
    } else {
      static_cast<btGeneric6DofConstraint&>(*main_).setLimit(
          axis.dof, std::max(axis.law.lower, -kUnbounded), std::min(axis.law.upper, kUnbounded));
    }
  }
}

/// Of an angle, as Bullet measures it but for its sign.
void ConstraintJoint::set_limits(const Axis& axis, double lower, double upper) {
  if (type_ == JointType::hinge) {
    // Bullet's softness and bias; without relaxation nothing bounces.
    static_cast<btHingeConstraint&>(*main_).setLimit(lower, upper, 0.9, 0.3, 0.0);
    return;
  }
  // Its angles have the other sign; setLimit() would wrap the two one by one.
  auto& motor =
      *static_cast<btGeneric6DofConstraint&>(*main_).getRotationalLimitMotor(axis.dof - 3);
  const double turns = 2.0 * kPi * std::round((lower + upper) / (4.0 * kPi));
  motor.m_loLimit = turns - upper;
  motor.m_hiLimit = turns - lower;
}

void ConstraintJoint::set_wide_limits(const Axis& axis, double q) {
  double angle = 0.0;
  if (type_ == JointType::hinge) {
    angle = static_cast<btHingeConstraint&>(*main_).getHingeAngle();
  } else {
    auto& six = static_cast<btGeneric6DofConstraint&>(*main_);
    six.calculateTransforms();
    angle = -six.getAngle(axis.dof - 3);
  }
  set_limits(axis, std::max(axis.law.lower, q - kNear) - q + angle,
             std::min(axis.law.upper, q + kNear) - q + angle);
}

void ConstraintJoint::add_to(btDiscreteDynamicsWorld& world, int sweeps) {
  main_->setOverrideNumSolverIterations(sweeps);
  for (const auto& extra : extras_) extra->constraint->setOverrideNumSolverIterations(sweeps);
  world.addConstraint(main_.get(), !collide_);
  for (const auto& extra : extras_) world.addConstraint(extra->constraint.get(), false);
}

btVector3 ConstraintJoint::direction(const Axis& axis, const btTransform& X_A,
                                     const btTransform& X_B) const {
  return (axis.on_child ? X_B : X_A).getBasis() * axis.direction;
}

double ConstraintJoint::speed(const Axis& axis, const btVector3& along) const {
  if (axis.angular) return along.dot(b_.getAngularVelocity() - a_.getAngularVelocity());
  const btVector3 M = b_.getWorldTransform() * frame_b_.getOrigin();
  return along.dot(b_.getVelocityInLocalPoint(M - b_.getCenterOfMassPosition()) -
                   a_.getVelocityInLocalPoint(M - a_.getCenterOfMassPosition()));
}

double ConstraintJoint::inverse_mass(const Axis& axis, const btVector3& along) const {
  double sum = 0.0;
  for (const btRigidBody* body : {&a_, &b_}) {
    if (axis.angular) {
      sum += along.dot(body->getInvInertiaTensorWorld() * along);
      continue;
    }
    sum += body->getInvMass();
    const btVector3 arm =
        (b_.getWorldTransform() * frame_b_.getOrigin() - body->getCenterOfMassPosition())
            .cross(along);
    sum += arm.dot(body->getInvInertiaTensorWorld() * arm);
  }
  return sum;
}

void ConstraintJoint::drive(const Axis& axis, Row& row, double dt, double velocity,
                            double softness) {
  const double bound = std::min(row.bound, kUnbounded);
  const std::array<double, 4> given = {velocity, bound, dt, softness};
  if (std::exchange(row.on, true) && row.given == given) return;
  row.given = given;
  if (!row.extra && type_ == JointType::hinge) {
    auto& hinge = static_cast<btHingeConstraint&>(*main_);
    hinge.enableAngularMotor(true, velocity, bound * dt);
    hinge.setParam(BT_CONSTRAINT_CFM, softness);
    return;
  }
  auto& six = row.extra ? *row.extra->constraint : static_cast<btGeneric6DofConstraint&>(*main_);
  // Its speeds have the other sign.
  enable(six, axis.dof, true);
  if (axis.angular) {
    six.getRotationalLimitMotor(axis.dof - 3)->m_targetVelocity = -velocity;
    six.getRotationalLimitMotor(axis.dof - 3)->m_maxMotorForce = bound;
  } else {
    six.getTranslationalLimitMotor()->m_targetVelocity[axis.dof] = -velocity;
    six.getTranslationalLimitMotor()->m_maxMotorForce[axis.dof] = bound;
  }
  six.setParam(BT_CONSTRAINT_CFM, softness, axis.dof);
}

void ConstraintJoint::stop(const Axis& axis, Row& row) {
  if (!row.on) return;
  row.on = false;
  if (!row.extra && type_ == JointType::hinge)
    return static_cast<btHingeConstraint&>(*main_).enableMotor(false);
  enable(row.extra ? *row.extra->constraint : static_cast<btGeneric6DofConstraint&>(*main_),
         axis.dof, false);
}

/// A spring and damper with a bound: effort = clamp(bias + kp (position - q) + kd (velocity - u)).
///
/// Semi-implicit Euler holds it as an explicit effort while s = dt (kd + dt kp) / m stays below
/// about 2, m being the effective mass at the axis. Beyond, it becomes a motor of Bullet's, a speed
/// source with the softness u+ = v - impulse / (K dt), see SoftSource.
///
/// Beside a rotor, Bullet's sweeps would take turns between two stiff rows: a law that is not near
/// its bound goes into the rotor's row, and one that is beyond it is a constant effort. The effort
/// is foretold from the bodies' own inertia, which is the least that the axis can have.
void ConstraintJoint::apply_law(const Axis& axis, const btVector3& along, Row& row,
                                const Drive& law, double dt, double q, double u) {
  const double rotor = axis.law.rotor_inertia;
  row.bound = law.max_effort;
  row.gain = 0.0;
  if (law.is_speed_source() && rotor == 0.0) return drive(axis, row, dt, law.velocity, softness_);
  auto [gain, held] = at_end_of_step(law, dt, q);
  const double inverse = gain > 0.0 ? inverse_mass(axis, along) : 0.0;
  const double mass = inverse > 0.0 ? 1.0 / inverse + rotor : rotor;
  if (law.is_speed_source()) {
    gain = kSource * mass / dt;
    held = gain * law.velocity;
  }
  const double s = gain > 0.0 ? dt * gain / mass : 0.0;
  const double foretold = std::abs(held - gain * u) / (1.0 + s);
  if (s < stiff_ || (rotor > 0.0 && foretold >= law.max_effort)) {
    stop(axis, row);
    row.effort =
        std::clamp(held - (s < stiff_ ? law.kd : gain) * u, -law.max_effort, law.max_effort);
  } else if (rotor > 0.0 && foretold < kFarFromBound * law.max_effort) {
    stop(axis, row);
    row.gain = gain;
    row.target = held / gain;
  } else {
    drive(axis, row, dt, held / gain, softness_ + 1.0 / (dt * gain * inverse));
  }
}

/// The inertia of a rotor, and what apply_law() leaves to its row.
void ConstraintJoint::apply_rotor(Axis& axis, const btVector3& along, double dt, double u) {
  double gain = axis.law.rotor_inertia / dt, held = gain * u;
  for (const Row& row : axis.rows) {
    gain += row.gain;
    held += row.gain * row.target;
  }
  Row& row = axis.rows.back();
  row.bound = kUnbounded;
  drive(axis, row, dt, held / gain, softness_ + 1.0 / (dt * gain * inverse_mass(axis, along)));
}

/// Bullet's angles are those of Euler: only where they are zero do its axes not depend on them.
void ConstraintJoint::align_extras() {
  const btTransform X_BA = b_.getWorldTransform().inverse() * a_.getWorldTransform();
  for (const auto& extra : extras_) extra->constraint->setFrames(frame_a_, X_BA * frame_a_);
}

void ConstraintJoint::push(const btVector3& force, const btVector3& torque) {
  explicit_.force += force;
  explicit_.torque += torque;
  const btVector3 M = b_.getWorldTransform() * frame_b_.getOrigin();
  b_.applyForce(force, M - b_.getCenterOfMassPosition());
  b_.applyTorque(torque);
  a_.applyForce(-force, M - a_.getCenterOfMassPosition());
  a_.applyTorque(-torque);
}

void ConstraintJoint::apply(const StepInput& input) {
  if (!has_laws_ && input.efforts.empty()) return;
  const double* const efforts = input.efforts.empty() ? nullptr : &input.efforts[first_speed_];
  const double *q = nullptr, dt = input.dt;
  explicit_ = {};
  if (type_ == JointType::ball) align_extras();
  stiff_ = efforts ? kSoft : kStiff;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    const btVector3 along = direction(axis, a_.getWorldTransform(), b_.getWorldTransform());
    const auto coordinate = [&] { return (q ? q : q = input.coordinates(joint_))[i]; };
    double effort = efforts ? efforts[i] : 0.0;
    if (axis.wide) set_wide_limits(axis, coordinate());
    for (Row& row : axis.rows) {
      row.effort = 0.0;
      if (row.kind == Kind::rotor) {
        apply_rotor(axis, along, dt, speed(axis, along));
        continue;
      }
      if (row.kind == Kind::friction) {
        row.bound = axis.law.friction;
        drive(axis, row, dt, 0.0, softness_);
        continue;
      }
      Drive law{0.0, axis.law.stiffness, axis.law.rest, axis.law.damping};
      if (row.kind == Kind::motor) law = input.drives[row.motor];
      const double at = law.is_speed_source() ? 0.0 : coordinate();
      apply_law(axis, along, row, law, dt, at, speed(axis, along));
      effort += row.effort;
    }
    if (effort == 0.0) continue;
    axis.angular ? push({0, 0, 0}, along * effort) : push(along * effort, {0, 0, 0});
  }
}

double ConstraintJoint::rotor_ratio(std::size_t axis) const {
  if (axis >= axes_.size()) return 0.0;
  const Axis& it = axes_[axis];
  const btVector3 along = direction(it, a_.getWorldTransform(), b_.getWorldTransform());
  return it.law.rotor_inertia * inverse_mass(it, along);
}

Load ConstraintJoint::get_reaction(const btTransform& X_B) const {
  const btVector3 arm = X_B.getBasis() * frame_b_.getOrigin();
  Load out = explicit_;
  const auto add = [&](const Load& load) {
    out.force += load.force;
    out.torque += load.torque - arm.cross(load.force);
  };
  add(load_);
  for (const auto& extra : extras_) add(extra->load);
  return out;
}

void ConstraintJoint::clear_loads() {
  load_ = {};
  for (const auto& extra : extras_) extra->load = {};
}

void ConstraintJoint::get_efforts(const btTransform& X_A, const btTransform& X_B, double* joint,
                                  std::vector<double>& motors) const {
  const btVector3 arm = X_B.getBasis() * frame_b_.getOrigin();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Axis& axis = axes_[i];
    if (axis.rows.empty() && !axis.law.has_limit()) continue;
    const btVector3 along = direction(axis, X_A, X_B);
    const auto part = [&](const Load& load) {
      return along.dot(axis.angular ? load.torque - arm.cross(load.force) : load.force);
    };
    joint[i] = part(load_);
    for (const Row& row : axis.rows) {
      double effort = row.effort;
      if (row.kind == Kind::rotor) {  // its own effort is inertia, what others gave it is theirs
        if (!row.extra) joint[i] -= part(load_);
        continue;
      }
      if (row.gain > 0.0) effort = row.gain * (row.target - speed(axis, along));
      if (row.on && row.extra) effort = part(row.extra->load);
      if (row.on && !row.extra) effort = joint[i];
      if (row.extra || !row.on) joint[i] += effort;
      if (row.kind == Kind::motor) motors[row.motor] = effort;
    }
  }
}

}  // namespace cogrsim::bullet
