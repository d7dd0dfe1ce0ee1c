#include "joints.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/axis_laws.h"

namespace cogrsim::ode {

namespace {

// A direction that was turned into a frame and back is off by some last digits.
constexpr double kRounding = 1e-15;
constexpr double kFits = 1e-9;  // [m], [rad]
// With limits nearer to each other than this an angle says which of them it is beyond [rad].
constexpr double kNarrow = 6.0;

// A stop and a motor at once are two rows for one speed, which Dantzig's method tells apart by their
// CFM alone. Over the step it must be well above the rounding of the speed's mobility, 2e-16 of it,
// or a pivot is zero and ODE ends in an assertion: at 1 ms ODE's 1e-10 is too little for axes
// lighter than 1e-6 kg m^2 (NAO's hands: 1e-9 kg m^2).
constexpr double kSingular = 1e-12;

Vec3 cleaned(Vec3 direction) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(direction[i]) < kRounding) direction[i] = 0.0;
  }
  return direction.normalized();
}

void set_param(dJointID id, int parameter, double value) {
  switch (dJointGetType(id)) {
    case dJointTypeHinge:
      return dJointSetHingeParam(id, parameter, value);
    case dJointTypeSlider:
      return dJointSetSliderParam(id, parameter, value);
    case dJointTypeUniversal:
      return dJointSetUniversalParam(id, parameter, value);
    case dJointTypePiston:
      return dJointSetPistonParam(id, parameter, value);
    case dJointTypeAMotor:
      return dJointSetAMotorParam(id, parameter, value);
    case dJointTypeLMotor:
      return dJointSetLMotorParam(id, parameter, value);
    default:
      return;
  }
}

bool has_motors(JointType type) { return type != JointType::fixed && type != JointType::free; }

// Where ODE, which knows angles from -pi to pi only, has its zero of an axis: in the middle of two
// stops of which one is beyond that and which it can tell apart, else where the scene's is.
double zero_between_stops(const Joint& joint, int axis) {
  const JointAxis& stops = joint.axes[axis];
  const double range = stops.upper - stops.lower;
  if (!axis_turns(joint.type, axis) || !(range < kNarrow) ||
      (stops.lower > -kPi && stops.upper < kPi)) {
    return 0.0;
  }
  return 0.5 * (stops.lower + stops.upper);
}

// Whether a coordinate can come to a stop of which ODE's angle knows nothing.
bool is_wide(const Joint& joint, int axis) {
  const JointAxis& stops = joint.axes[axis];
  return axis_turns(joint.type, axis) && stops.has_limit() &&
         !(stops.upper - stops.lower < kNarrow);
}

}  // namespace

JointLink::JointLink(dWorldID world, const SceneModel& model, int joint, const JointEnd& parent,
                     const JointEnd& child, double cfm)
    : joint_(&model.joints[joint]), index_(joint), parent_(parent), child_(child), cfm_(cfm) {
  const auto is_mobile = [](const JointEnd& end) {
    return end.body && dBodyIsKinematic(end.id()) == 0;
  };
  if (joint_->type == JointType::free || (!is_mobile(parent) && !is_mobile(child))) return;
  // ODE's first body must be one; what ODE calls a positive rate is that of the first.
  sign_ = child.body ? 1.0 : -1.0;
  first_ = child.body ? child : parent;
  second_ = child.body ? parent : JointEnd();

  // ODE's coordinates are zero where a joint is made.
  const bool has_stops = has_motors(joint_->type) && joint_->type != JointType::planar &&
                         joint_->type != JointType::ball;
  std::array<double, 7> zero{};
  bool is_ours = true;  // it is made where the scene's are zero
  for (std::size_t i = 0; has_stops && i < joint_->axes.size(); ++i) {
    zero[i] = zero_between_stops(*joint_, static_cast<int>(i));
    is_ours = is_ours && zero[i] == 0.0;
  }
  const Pose X_FM = is_ours ? Pose() : joint_pose(*joint_, zero.data());
  Pose X_WF = parent.start * joint_->X_PF, X_WM = child.start * joint_->X_CM;
  if (const Pose off = X_FM.inverse() * (X_WF.inverse() * X_WM);
      !(off.p.norm() < kFits && off.q.vec().norm() < kFits)) {
    if (child.body) {
      X_WM = is_ours ? X_WF : X_WF * X_FM;  // without a rounding where none is needed
      child.body->set_pose(X_WM * joint_->X_CM.inverse());
    } else {
      X_WF = is_ours ? X_WM : X_WM * X_FM.inverse();
      parent.body->set_pose(X_WF * joint_->X_PF.inverse());
    }
  }
  make(world, X_WF, X_WM);
  for (std::size_t i = 0; has_stops && i < joint_->axes.size(); ++i) {
    const JointAxis& axis = joint_->axes[i];
    if (!axis.has_limit()) continue;
    if (is_wide(*joint_, static_cast<int>(i))) {
      wide_ = true;
      continue;
    }
    const int group = group_of(static_cast<int>(i));
    set_param(id_, dParamLoStop + group, axis.lower - zero[i]);
    set_param(id_, dParamHiStop + group, axis.upper - zero[i]);
  }
  add_laws(world, model, joint, X_WF, X_WM);
}

bool JointLink::turns(int speed) const { return axis_turns(joint_->type, speed); }

int JointLink::relative_to_parent() const { return sign_ < 0.0 ? 1 : second_.body ? 2 : 0; }

dJointID JointLink::attached(dJointID id, dJointFeedback& feedback) const {
  dJointAttach(id, first_.id(), second_.id());
  dJointSetFeedback(id, &feedback);
  return id;
}

void JointLink::make(dWorldID world, const Pose& X_WF, const Pose& X_WM) {
  // What needs no rounding: the origin of the child where the joint is there.
  const Vec3 at = joint_->X_CM.p.isZero(0.0) ? X_WM.p : X_WF.p;
  const Vec3 z = sign_ * cleaned(X_WF.q * Vec3::UnitZ());
  switch (joint_->type) {
    case JointType::fixed:
      id_ = attached(dJointCreateFixed(world, nullptr), feedback_);
      dJointSetFixed(id_);
      return;
    case JointType::hinge:
      id_ = attached(dJointCreateHinge(world, nullptr), feedback_);
      dJointSetHingeAnchor(id_, at.x(), at.y(), at.z());
      dJointSetHingeAxis(id_, z.x(), z.y(), z.z());
      return;
    case JointType::slider:
      id_ = attached(dJointCreateSlider(world, nullptr), feedback_);
      dJointSetSliderAxis(id_, z.x(), z.y(), z.z());
      return;
    case JointType::cylindrical:
      id_ = attached(dJointCreatePiston(world, nullptr), feedback_);
      dJointSetPistonAnchor(id_, at.x(), at.y(), at.z());
      dJointSetPistonAxis(id_, z.x(), z.y(), z.z());
      return;
    case JointType::universal: {
      // ODE's first axis belongs to the first body: y of M, or x of F where that is the parent.
      const Vec3 x = cleaned(X_WF.q * Vec3::UnitX()), y = cleaned(X_WM.q * Vec3::UnitY());
      const Vec3 one = sign_ > 0.0 ? y : Vec3(-x), two = sign_ > 0.0 ? x : Vec3(-y);
      id_ = attached(dJointCreateUniversal(world, nullptr), feedback_);
      dJointSetUniversalAnchor(id_, at.x(), at.y(), at.z());
      dJointSetUniversalAxis1(id_, one.x(), one.y(), one.z());
      dJointSetUniversalAxis2(id_, two.x(), two.y(), two.z());
      return;
    }
    case JointType::ball:
      id_ = attached(dJointCreateBall(world, nullptr), feedback_);
      dJointSetBallAnchor(id_, at.x(), at.y(), at.z());
      return;
    case JointType::planar:
      return make_planar(world, X_WF, X_WM);
    case JointType::screw:
    case JointType::gimbal:
    case JointType::free:
      return;
  }
}

void JointLink::make_planar(dWorldID world, const Pose& X_WF, const Pose& X_WM) {
  // ODE's Plane2D knows the plane z = 0 of the world only, so: two Euler angles stopped at zero,
  // the third free, and no speed along the normal.
  const Vec3 x = cleaned((sign_ > 0.0 ? X_WM.q : X_WF.q) * Vec3::UnitX());
  const Vec3 z = sign_ * cleaned(X_WF.q * Vec3::UnitZ());
  id_ = attached(dJointCreateAMotor(world, nullptr), feedback_);
  dJointSetAMotorMode(id_, dAMotorEuler);
  dJointSetAMotorAxis(id_, 0, 1, x.x(), x.y(), x.z());
  dJointSetAMotorAxis(id_, 2, 2, z.x(), z.y(), z.z());
  for (const int group : {0, int{dParamGroup}}) {
    dJointSetAMotorParam(id_, dParamLoStop + group, 0.0);
    dJointSetAMotorParam(id_, dParamHiStop + group, 0.0);
  }
  normal_ = attached(dJointCreateLMotor(world, nullptr), normal_feedback_);
  dJointSetLMotorNumAxes(normal_, 1);
  dJointSetLMotorAxis(normal_, 0, relative_to_parent(), z.x(), z.y(), z.z());
  dJointSetLMotorParam(normal_, dParamVel, 0.0);
  dJointSetLMotorParam(normal_, dParamFMax, dInfinity);
}

int JointLink::group_of(int speed) const {
  const bool first = joint_->type == JointType::cylindrical
                         ? speed == 1  // ODE's first is the travel
                     : joint_->type == JointType::universal ? (speed == 1) == (sign_ > 0.0)
                                                            : true;
  return first ? 0 : int{dParamGroup};
}

JointLink::Law& JointLink::add_law(dWorldID world, int speed, bool own, const Vec3& direction) {
  Law& law = laws_.emplace_back();
  law.speed = speed;
  law.own = own;
  if (own) {
    law.id = id_;
    law.group = group_of(speed);
    return law;
  }
  // Of the universal's axes the first is F's, as all of planar and ball joints are; others M's or
  // both's.
  const bool of_parent = normal_ || joint_->type == JointType::ball ||
                         (joint_->type == JointType::universal && speed == 0);
  const int of_child = sign_ > 0.0 ? 1 : 0;
  const int relative = of_parent                              ? relative_to_parent()
                       : joint_->type == JointType::universal ? of_child
                                                              : 1;
  const Vec3 d = sign_ * cleaned(direction);
  if (turns(speed)) {
    law.id = attached(dJointCreateAMotor(world, nullptr), law.feedback);
    dJointSetAMotorNumAxes(law.id, 1);
    dJointSetAMotorAxis(law.id, 0, relative, d.x(), d.y(), d.z());
  } else {
    law.id = attached(dJointCreateLMotor(world, nullptr), law.feedback);
    dJointSetLMotorNumAxes(law.id, 1);
    dJointSetLMotorAxis(law.id, 0, relative, d.x(), d.y(), d.z());
  }
  return law;
}

void JointLink::add_laws(dWorldID world, const SceneModel& model, int joint, const Pose& X_WF,
                         const Pose& X_WM) {
  if (!has_motors(joint_->type) || joint_->axes.empty()) return;
  for (int i = 0; i < speed_count(joint_->type); ++i) {
    const JointAxis& axis = axis_of_speed(*joint_, i);
    bool own = !axis.has_limit() && !normal_ && joint_->type != JointType::ball;
    const auto add = [&]() -> Law& {
      return add_law(world, i, std::exchange(own, false), direction(i, X_WF, X_WM));
    };
    for (const int motor : motors_of(model, joint, i)) add().drive = motor;
    if (axis.friction > 0.0) set(add(), 0.0, axis.friction, cfm_);
    if (axis.damping > 0.0) set(add(), 0.0, dInfinity, 1.0 / axis.damping);
    if (axis.rotor_inertia > 0.0) add().rotor = has_rotor_ = true;
    if (axis.stiffness > 0.0) {
      Law& spring = laws_.emplace_back();
      spring.speed = i;
      spring.spring = true;
    }
    for (Law& law : laws_)
      if (law.speed == i) law.least = kSingular * model.physics.step * mobility(i);
  }
}

void JointLink::set(Law& law, double velocity, double bound, double cfm) const {
  cfm = std::max(cfm, law.least);
  const std::array<double, 3> motor = {velocity, bound, cfm};
  if (motor == law.motor) return;
  law.motor = motor;
  set_param(law.id, dParamVel + law.group, velocity);
  set_param(law.id, dParamFMax + law.group, bound);
  set_param(law.id, dParamCFM + law.group, cfm);
}

void JointLink::set(Law& law, const Drive& drive, const StepInput& input) const {
  if (drive.is_speed_source()) return set(law, drive.velocity, drive.max_effort, cfm_);
  const double q = drive.kp > 0.0 ? input.coordinates(index_)[law.speed] : 0.0;
  const SoftSource soft = at_end_of_step(drive, input.dt, q);
  if (soft.gain > 0.0) return set(law, soft.speed(), drive.max_effort, 1.0 / soft.gain);
  set(law, 0.0, 0.0, cfm_);
  law.applied = std::clamp(drive.bias, -drive.max_effort, drive.max_effort);
  push(law.speed, law.applied);
}

void JointLink::push(int speed, double effort) const {
  if (effort == 0.0) return;
  const Pose X_WF = parent_.pose() * joint_->X_PF, X_WM = child_.pose() * joint_->X_CM;
  const Vec3 d = effort * direction(speed, X_WF, X_WM), &at = X_WM.p;
  for (const double side : {1.0, -1.0}) {
    const dBodyID body = side > 0.0 ? child_.id() : parent_.id();
    if (!body) continue;
    const Vec3 e = side * d;
    if (turns(speed)) {
      dBodyAddTorque(body, e.x(), e.y(), e.z());
    } else {
      dBodyAddForceAtPos(body, e.x(), e.y(), e.z(), at.x(), at.y(), at.z());
    }
  }
}

double JointLink::stop_angle(int axis) const {
  switch (dJointGetType(id_)) {
    case dJointTypeHinge:
      return dJointGetHingeAngle(id_);
    case dJointTypePiston:
      return dJointGetPistonAngle(id_);
    default:
      return group_of(axis) == 0 ? dJointGetUniversalAngle1(id_) : dJointGetUniversalAngle2(id_);
  }
}

void JointLink::set_wide_stops(const double* q) const {
  for (std::size_t i = 0; i < joint_->axes.size(); ++i) {
    const int axis = static_cast<int>(i), group = group_of(axis);
    if (!is_wide(*joint_, axis)) continue;
    // ODE takes an angle for free where both are beyond half a turn.
    const double off = stop_angle(axis) - q[i];
    set_param(id_, dParamLoStop + group, joint_->axes[i].lower + off);
    set_param(id_, dParamHiStop + group, joint_->axes[i].upper + off);
  }
}

void JointLink::drive(const StepInput& input) {
  double u[6];
  if (!id_) return;
  if (wide_) set_wide_stops(input.coordinates(index_));
  if (has_rotor_) velocities(input.coordinates(index_), u);
  for (Law& law : laws_) {
    law.applied = 0.0;
    const JointAxis& axis = axis_of_speed(*joint_, law.speed);
    if (law.drive >= 0) {
      set(law, input.drives[law.drive], input);
    } else if (law.rotor) {
      set(law, u[law.speed], dInfinity, input.dt / axis.rotor_inertia);
    } else if (law.spring) {
      law.applied = axis.stiffness * (axis.rest - input.coordinates(index_)[law.speed]);
      push(law.speed, law.applied);
    }
  }
  for (int i = 0; !input.efforts.empty() && i < speed_count(joint_->type); ++i) {
    pushed_[i] = input.efforts[joint_->speed_offset + i];
    push(i, pushed_[i]);
  }
}

double JointLink::mobility(int speed) const {
  const Vec3 d = direction(speed, parent_.pose() * joint_->X_PF, child_.pose() * joint_->X_CM);
  double out = 0.0;
  for (const JointEnd* end : {&parent_, &child_}) {
    if (!end->id() || dBodyIsKinematic(end->id()) != 0) continue;
    dMass mass;
    dBodyGetMass(end->id(), &mass);
    const Vec3 local = end->pose().q.conjugate() * d;
    out += turns(speed) ? local.dot(to_mat(mass.I).inverse() * local) : 1.0 / mass.mass;
  }
  return out;
}

std::vector<double> JointLink::rotor_ratios() const {
  std::vector<double> out(std::size_t(speed_count(joint_->type)), 0.0);
  for (const Law& law : laws_)
    if (law.rotor)
      out[law.speed] = axis_of_speed(*joint_, law.speed).rotor_inertia * mobility(law.speed);
  return out;
}

void JointLink::velocities(const double* q, double* u) const {
  const Pose X_WP = parent_.pose(), X_WC = child_.pose();
  joint_velocity(*joint_, relative_pose(*joint_, X_WP, X_WC),
                 relative_twist(*joint_, X_WP, parent_.twist(), X_WC, child_.twist()), q, u);
}

Vec3 JointLink::direction(int speed, const Pose& X_WF, const Pose& X_WM) const {
  if (joint_->type == JointType::universal)
    return speed == 0 ? Vec3(X_WF.q * Vec3::UnitX()) : Vec3(X_WM.q * Vec3::UnitY());
  if (joint_->type == JointType::planar || joint_->type == JointType::ball)
    return X_WF.q * axis_direction(joint_->type, speed);
  return (sign_ > 0.0 ? X_WM.q : X_WF.q) * Vec3::UnitZ();
}

void JointLink::report(double h, const JointReport& out) const {
  if (!id_) return;
  const Pose X_WF = parent_.pose_before(h) * joint_->X_PF;
  const Pose X_WM = child_.pose_before(h) * joint_->X_CM;
  const Vec3 arm = first_.body->centre_before(h) - X_WM.p;
  const auto on_child = [&](const dJointFeedback& feedback) {
    const Vec3 f = to_vec(feedback.f1);
    const Wrench wrench{sign_ * f, sign_ * (to_vec(feedback.t1) + arm.cross(f))};
    out.reaction->force += wrench.force;
    out.reaction->torque += wrench.torque;
    return wrench;
  };
  const auto along = [&](const Wrench& wrench, int speed) {
    return (turns(speed) ? wrench.torque : wrench.force).dot(direction(speed, X_WF, X_WM));
  };
  const Wrench main = on_child(feedback_);
  if (normal_) on_child(normal_feedback_);
  if (!has_motors(joint_->type)) return;
  // Along an axis the joint itself transmits its stops and its own motor.
  for (int i = 0; i < speed_count(joint_->type); ++i) out.joint_efforts[i] = along(main, i);
  const auto add_explicit = [&](int speed, double effort) {
    if (effort == 0.0) return;
    const Vec3 e = effort * direction(speed, X_WF, X_WM);
    (turns(speed) ? out.reaction->torque : out.reaction->force) += e;
  };
  for (int i = 0; i < speed_count(joint_->type); ++i) add_explicit(i, pushed_[i]);
  for (const Law& law : laws_) {
    double effort = law.applied;
    if (law.rotor) {  // inertia is not an effort of the joint's
      law.own ? void(out.joint_efforts[law.speed] -= along(main, law.speed))
              : void(on_child(law.feedback));
      continue;
    }
    add_explicit(law.speed, effort);
    if (effort == 0.0 && law.motor[1] > 0.0 && !law.own)
      effort = along(on_child(law.feedback), law.speed);
    out.joint_efforts[law.speed] += effort;
    if (law.drive < 0) continue;
    out.motor_efforts[law.drive] = law.own && law.motor[1] > 0.0 ? along(main, law.speed) : effort;
  }
}

}  // namespace cogrsim::ode
