#include "constraint_joint.h"

#include <BulletDynamics/ConstraintSolver/btFixedConstraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "convert.h"

namespace cogrsim::bullet {

namespace {

void zero(btJointFeedback& feedback) {
  feedback.m_appliedForceBodyA.setZero();
  feedback.m_appliedTorqueBodyA.setZero();
  feedback.m_appliedForceBodyB.setZero();
  feedback.m_appliedTorqueBodyB.setZero();
}

/// Bullet measures angles within half a turn: a limit wider than that, or on one side, is set when
/// the coordinate comes within a quarter turn of it.
bool is_within_turn(const JointAxis& axis) { return axis.upper - axis.lower < 2.0 * kPi - 0.1; }

}  // namespace

ConstraintJoint::ConstraintJoint(const SceneModel& model, int joint, btRigidBody& a, btRigidBody& b,
                                 const btTransform& frame_a, const btTransform& frame_b)
    : joint_(joint),
      type_(model.joints[at(joint)].type),
      a_(a),
      b_(b),
      frame_a_(frame_a),
      frame_b_(frame_b) {
  const Joint& made = model.joints[at(joint)];
  collide_ = made.bodies_collide;
  switch (type_) {
    case JointType::hinge:
      main_ = std::make_unique<btHingeConstraint>(a, b, frame_a, frame_b, true);
      break;
    case JointType::ball:
      main_ =
          std::make_unique<btPoint2PointConstraint>(a, b, frame_a.getOrigin(), frame_b.getOrigin());
      break;
    case JointType::fixed:
      main_ = std::make_unique<btFixedConstraint>(a, b, frame_a, frame_b);
      break;
    default:
      // With this order x is turned about first, then y: what a universal joint needs.
      main_ = std::make_unique<btGeneric6DofSpring2Constraint>(a, b, frame_a, frame_b, RO_ZYX);
  }
  main_->setJointFeedback(&feedback_);
  make_axes(made);
  make_rows(model);
  zero(feedback_);
  if (auto* six = dynamic_cast<btGeneric6DofSpring2Constraint*>(main_.get())) {
    for (int dof = 0; dof < 6; ++dof) six->setLimit(dof, 0.0, 0.0);
    for (const Axis& axis : axes_) six->setLimit(axis.dof, 1.0, -1.0);
  }
  set_limits(made.position.empty() ? nullptr : made.position.data());
}

ConstraintJoint::~ConstraintJoint() = default;

void ConstraintJoint::make_axes(const Joint& joint) {
  const auto add = [&](int index, bool angular, int dof, bool on_child = false) {
    Axis axis;
    axis.direction = (on_child ? frame_b_ : frame_a_).getBasis().getColumn(index);
    axis.on_child = on_child;
    axis.angular = angular;
    axis.dof = dof;
    if (axes_.size() < joint.axes.size()) axis.law = joint.axes[axes_.size()];
    axes_.push_back(axis);
  };
  switch (type_) {
    case JointType::hinge:
      add(2, true, 5);
      break;
    case JointType::slider:
      add(2, false, 2);
      break;
    case JointType::cylindrical:
      add(2, true, 5);
      add(2, false, 2);
      break;
    case JointType::universal:
      add(0, true, 3);
      add(1, true, 4, true);
      break;
    case JointType::planar:
      add(0, false, 0);
      add(1, false, 1);
      add(2, true, 5);
      break;
    default:
      break;
  }
}

void ConstraintJoint::make_rows(const SceneModel& model) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    bool taken = false;  // the main constraint's motor
    const auto add = [&](Kind kind, int motor) {
      Row row;
      row.kind = kind;
      row.motor = motor;
      if (taken) row.extra = make_extra();
      taken = true;
      axis.rows.push_back(row);
    };
    for (std::size_t m = 0; m < model.motors.size(); ++m) {
      const Motor& motor = model.motors[m];
      if (motor.removed || motor.joint != joint_ || at(motor.axis) != i) continue;
      add(Kind::motor, static_cast<int>(m));
    }
    if (axis.law.friction > 0.0) add(Kind::friction, -1);
    if (axis.law.stiffness > 0.0 || axis.law.damping > 0.0) add(Kind::passive, -1);
    has_laws_ |= !axis.rows.empty();
    if (!axis.angular || !axis.law.has_limit()) continue;
    turning_limits_ |= !is_within_turn(axis.law);
  }
  has_laws_ |= turning_limits_;
}

ConstraintJoint::Extra* ConstraintJoint::make_extra() {
  auto extra = std::make_unique<Extra>();
  extra->constraint =
      std::make_unique<btGeneric6DofSpring2Constraint>(a_, b_, frame_a_, frame_b_, RO_ZYX);
  for (int dof = 0; dof < 6; ++dof) extra->constraint->setLimit(dof, 1.0, -1.0);
  extra->constraint->setJointFeedback(&extra->feedback);
  zero(extra->feedback);
  extras_.push_back(std::move(extra));
  return extras_.back().get();
}

void ConstraintJoint::set_limits(const double* q) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const JointAxis& law = axes_[i].law;
    if (!law.has_limit()) continue;
    if (!axes_[i].angular || is_within_turn(law)) {
      set_window(axes_[i], std::max(law.lower, -kUnbounded), std::min(law.upper, kUnbounded));
      continue;
    }
    const double now = q ? q[i] : 0.0;
    if (now > law.upper - kPi / 2) {
      set_window(axes_[i], law.upper - kPi, law.upper);
    } else if (now < law.lower + kPi / 2) {
      set_window(axes_[i], law.lower, law.lower + kPi);
    } else {
      set_window(axes_[i], 1.0, -1.0);
    }
  }
}

void ConstraintJoint::set_window(const Axis& axis, double lower, double upper) {
  if (type_ == JointType::hinge) {
    // Bias 1 and relaxation 0: the stop takes its error back as any joint does, and nothing bounces.
    static_cast<btHingeConstraint&>(*main_).setLimit(lower, upper, 0.9, 1.0, 0.0);
  } else if (!axis.angular) {
    static_cast<btGeneric6DofSpring2Constraint&>(*main_).setLimit(axis.dof, lower, upper);
  } else {
    // Its angles have the other sign; it wraps them, we have not.
    auto& six = static_cast<btGeneric6DofSpring2Constraint&>(*main_);
    const double turns = lower > upper ? 0.0 : std::round((lower + upper) / (4.0 * kPi));
    btRotationalLimitMotor2& motor = *six.getRotationalLimitMotor(axis.dof - 3);
    motor.m_loLimit = lower > upper ? 1.0 : -(upper - 2.0 * kPi * turns);
    motor.m_hiLimit = lower > upper ? -1.0 : -(lower - 2.0 * kPi * turns);
  }
}

void ConstraintJoint::add_to(btDiscreteDynamicsWorld& world) {
  world.addConstraint(main_.get(), !collide_);
  for (const auto& extra : extras_) world.addConstraint(extra->constraint.get(), false);
}

void ConstraintJoint::remove_from(btDiscreteDynamicsWorld& world) {
  for (const auto& extra : extras_) world.removeConstraint(extra->constraint.get());
  world.removeConstraint(main_.get());
}

std::vector<btTypedConstraint*> ConstraintJoint::constraints() const {
  std::vector<btTypedConstraint*> out = {main_.get()};
  for (const auto& extra : extras_) out.push_back(extra->constraint.get());
  return out;
}

bool ConstraintJoint::needs_position(const std::vector<Drive>& drives) const {
  if (turning_limits_) return true;
  for (const Axis& axis : axes_) {
    for (const Row& row : axis.rows) {
      if (row.kind == Kind::passive) return true;
      if (row.kind != Kind::motor) continue;
      const Drive& drive = drives[at(row.motor)];
      if (drive.kp != 0.0 && !drive.is_speed_source()) return true;
    }
  }
  return false;
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

/// How much of the first axis of a universal joint is in the row that Bullet makes for it, which
/// stands across the child's z.
double ConstraintJoint::slant(const Axis& axis) const {
  if (type_ != JointType::universal || axis.dof != 3) return 1.0;
  const btVector3 x = a_.getWorldTransform().getBasis() * axis.direction;
  const btVector3 z = b_.getWorldTransform().getBasis() * frame_b_.getBasis().getColumn(2);
  return std::sqrt(std::max(1e-6, 1.0 - x.dot(z) * x.dot(z)));
}

void ConstraintJoint::drive(const Axis& axis, Row& row, double dt, double velocity,
                            double softness) {
  row.on = true;
  const double bound = std::min(row.bound, kUnbounded);
  if (!row.extra && type_ == JointType::hinge) {
    auto& hinge = static_cast<btHingeConstraint&>(*main_);
    hinge.enableAngularMotor(true, velocity, bound * dt);
    hinge.setParam(BT_CONSTRAINT_CFM, softness);
    return;
  }
  auto& six =
      row.extra ? *row.extra->constraint : static_cast<btGeneric6DofSpring2Constraint&>(*main_);
  const double part = slant(axis);
  six.enableMotor(axis.dof, true);
  six.setTargetVelocity(axis.dof, -velocity * part);
  six.setMaxMotorForce(axis.dof, bound / part);
  six.setParam(BT_CONSTRAINT_CFM, softness, axis.dof);
}

void ConstraintJoint::stop(const Axis& axis, Row& row) {
  if (!row.on) return;
  row.on = false;
  if (row.extra) {
    row.extra->constraint->enableMotor(axis.dof, false);
  } else if (type_ == JointType::hinge) {
    static_cast<btHingeConstraint&>(*main_).enableMotor(false);
  } else {
    static_cast<btGeneric6DofSpring2Constraint&>(*main_).enableMotor(axis.dof, false);
  }
}

void ConstraintJoint::apply_law(const Axis& axis, Row& row, const AxisLaw& law, double dt, double q,
                                double u) {
  row.bound = law.bound;
  const double s =
      law.needs_state()
          ? dt * law.gain(dt) *
                inverse_mass(axis, direction(axis, a_.getWorldTransform(), b_.getWorldTransform()))
          : 0.0;
  if (s >= kStiff) {
    drive(axis, row, dt, law.source(q, dt), 1.0 / s);
  } else {
    stop(axis, row);
    row.effort = law.effort(q, u);
  }
}

void ConstraintJoint::push(const btVector3& force, const btVector3& torque) {
  force_ += force;
  torque_ += torque;
  const btVector3 M = b_.getWorldTransform() * frame_b_.getOrigin();
  b_.applyForce(force, M - b_.getCenterOfMassPosition());
  b_.applyTorque(torque);
  a_.applyForce(-force, M - a_.getCenterOfMassPosition());
  a_.applyTorque(-torque);
}

void ConstraintJoint::apply(double dt, const std::vector<Drive>& drives, const double* q) {
  force_.setZero();
  torque_.setZero();
  if (turning_limits_) set_limits(q);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    Axis& axis = axes_[i];
    double effort = 0.0;
    for (Row& row : axis.rows) {
      row.effort = 0.0;
      if (row.kind == Kind::friction) {
        row.bound = axis.law.friction;
        drive(axis, row, dt, 0.0, 0.0);
        continue;
      }
      const bool motor = row.kind == Kind::motor;
      if (motor && drives[at(row.motor)].is_speed_source()) {
        row.bound = drives[at(row.motor)].max_effort;
        drive(axis, row, dt, drives[at(row.motor)].velocity, 0.0);
        continue;
      }
      const AxisLaw law = motor ? AxisLaw::of(drives[at(row.motor)]) : AxisLaw::of(axis.law);
      const btVector3 along = direction(axis, a_.getWorldTransform(), b_.getWorldTransform());
      apply_law(axis, row, law, dt, q ? q[i] : 0.0, law.kd != 0.0 ? speed(axis, along) : 0.0);
      effort += row.effort;
    }
    if (effort == 0.0) continue;
    const btVector3 pushed =
        direction(axis, a_.getWorldTransform(), b_.getWorldTransform()) * effort;
    const btVector3 none(0, 0, 0);
    push(axis.angular ? none : pushed, axis.angular ? pushed : none);
  }
}

void ConstraintJoint::get_reaction(const btTransform& X_B, btVector3& force,
                                   btVector3& torque) const {
  const btVector3 arm = X_B.getBasis() * frame_b_.getOrigin();
  force = force_;
  torque = torque_;
  const auto add = [&](const btJointFeedback& feedback) {
    force += feedback.m_appliedForceBodyB;
    torque += feedback.m_appliedTorqueBodyB - arm.cross(feedback.m_appliedForceBodyB);
  };
  add(feedback_);
  for (const auto& extra : extras_) add(extra->feedback);
}

void ConstraintJoint::get_efforts(const btTransform& X_A, const btTransform& X_B, double* joint,
                                  std::vector<double>& motors) const {
  const btVector3 arm = X_B.getBasis() * frame_b_.getOrigin();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const Axis& axis = axes_[i];
    joint[i] = 0.0;
    if (axis.rows.empty() && !axis.law.has_limit()) continue;
    const btVector3 along = direction(axis, X_A, X_B);
    const auto part = [&](const btJointFeedback& feedback) {
      if (!axis.angular) return along.dot(feedback.m_appliedForceBodyB);
      return along.dot(feedback.m_appliedTorqueBodyB - arm.cross(feedback.m_appliedForceBodyB));
    };
    joint[i] = part(feedback_);
    for (const Row& row : axis.rows) {
      double effort = row.effort;
      if (row.on && row.extra) effort = part(row.extra->feedback);
      if (row.extra || !row.on) joint[i] += effort;
      // A limit that is touched shares the row of the main constraint's motor.
      if (row.on && !row.extra) effort = std::clamp(part(feedback_), -row.bound, row.bound);
      if (row.kind == Kind::motor) motors[at(row.motor)] = effort;
    }
  }
}

}  // namespace cogrsim::bullet
