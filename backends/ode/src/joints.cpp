#include "joints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::ode {

namespace {

// ODE applies all of a motor's bound where it is pushed into a stop; without a bound it gets this
// one there [N m], [N].
constexpr double kStrongest = 1e6;
// A direction that was turned into a frame and back is off by some last digits.
constexpr double kRounding = 1e-15;
constexpr double kFits = 1e-9;  // [m], [rad]

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

// The angle or travel by which ODE decides whether a joint is at a stop.
double coordinate(dJointID id, int group) {
  switch (dJointGetType(id)) {
    case dJointTypeHinge:
      return dJointGetHingeAngle(id);
    case dJointTypeSlider:
      return dJointGetSliderPosition(id);
    case dJointTypeUniversal: {
      dReal first = 0.0, second = 0.0;
      dJointGetUniversalAngles(id, &first, &second);
      return group == 0 ? first : second;
    }
    case dJointTypePiston:
      return group == 0 ? dJointGetPistonPosition(id) : dJointGetPistonAngle(id);
    case dJointTypeAMotor:
      return dJointGetAMotorAngle(id, group / dParamGroup);
    default:
      return 0.0;
  }
}

double stop_of(dJointID id, int parameter) {
  switch (dJointGetType(id)) {
    case dJointTypeHinge:
      return dJointGetHingeParam(id, parameter);
    case dJointTypeSlider:
      return dJointGetSliderParam(id, parameter);
    case dJointTypeUniversal:
      return dJointGetUniversalParam(id, parameter);
    case dJointTypePiston:
      return dJointGetPistonParam(id, parameter);
    case dJointTypeAMotor:
      return dJointGetAMotorParam(id, parameter);
    default:
      return 0.0;
  }
}

// The angle at which ODE's is to be zero, so that both stops lie within half a turn of it; false:
// there is none.
bool find_reference(const JointAxis& axis, double& reference) {
  reference = 0.0;
  if (!axis.has_limit()) return true;
  const bool one = std::isinf(axis.lower) || std::isinf(axis.upper);
  const double lower = std::isinf(axis.lower) ? 0.0 : axis.lower;
  const double upper = std::isinf(axis.upper) ? 0.0 : axis.upper;
  if (lower > -kPi && upper < kPi) return true;
  reference = 0.5 * (lower + upper);
  return !one && upper - lower < 2.0 * kPi;
}

bool has_axis(const Joint& joint, int speed) {
  return static_cast<std::size_t>(speed) < joint.axes.size();
}

}  // namespace

Result<> check_joints(const SceneModel& model) {
  if (auto fine = check_motors(model); !fine) return fine;
  for (const Joint& joint : model.joints) {
    if (joint.removed) continue;
    const std::string what = "joint '" + joint.name + "': ";
    if (joint.type == JointType::screw) {
      return fail(what + "ODE has no screw", place_of(model, joint.origin),
                  "use a hinge or a slider, or another backend");
    }
    for (std::size_t i = 0; i < joint.axes.size(); ++i) {
      const JointAxis& axis = joint.axes[i];
      if (!axis.has_limit()) continue;
      const bool turns = axis_turns(joint.type, static_cast<int>(i));
      if (joint.type == JointType::ball || (joint.type == JointType::planar && !turns)) {
        return fail(what + "ODE has no stops for this axis of a " +
                        std::string(to_string(joint.type)) + " joint",
                    place_of(model, joint.origin), "leave the limit out, or use another backend");
      }
      double reference = 0.0;
      if (turns && !find_reference(axis, reference)) {
        return fail(what + "ODE measures angles within one turn, these limits need more",
                    place_of(model, joint.origin),
                    "keep the limits less than one turn apart, or use another backend");
      }
    }
  }
  return {};
}

JointLink::JointLink(dWorldID world, const SceneModel& model, int joint, const JointEnd& parent,
                     const JointEnd& child, const Options& options)
    : joint_(&model.joints[static_cast<std::size_t>(joint)]), parent_(parent), child_(child) {
  cfm_ = options.cfm;
  const bool mobile = (parent.body && dBodyIsKinematic(parent.id()) == 0) ||
                      (child.body && dBodyIsKinematic(child.id()) == 0);
  if (joint_->type == JointType::free || !mobile) return;
  // ODE's first body must be one; what ODE calls a positive rate is that of the first.
  sign_ = child.body ? 1.0 : -1.0;
  first_ = child.body ? child : parent;
  second_ = child.body ? parent : JointEnd();

  // To where the joint's coordinates are the reference.
  const Joint& j = *joint_;
  double q[7] = {0.0};
  if (j.type == JointType::ball) q[0] = 1.0;
  for (int i = 0; i < speed_count(j.type); ++i) {
    if (j.type == JointType::ball || !has_axis(j, i) || !turns(i)) continue;
    find_reference(j.axes[static_cast<std::size_t>(i)], reference_[i]);
    q[i] = reference_[i];
  }
  const Pose X_FM = joint_pose(j, q);
  const Pose off = X_FM.inverse() * relative_pose(j, parent.pose(), child.pose());
  if (!(off.p.norm() < kFits && off.q.vec().norm() < kFits)) {
    const Pose X_WF = parent.pose() * j.X_PF;
    const Pose X_WM = child.pose() * j.X_CM;
    if (child.body) {
      const_cast<BodyLink*>(child.body)->set_pose(X_WF * X_FM * j.X_CM.inverse());
    } else {
      const_cast<BodyLink*>(parent.body)->set_pose(X_WM * X_FM.inverse() * j.X_PF.inverse());
    }
  }
  make(world, options);
  set_stops();
  add_motors(world, model, joint, options);
}

bool JointLink::turns(int speed) const { return axis_turns(joint_->type, speed); }

int JointLink::relative_to(bool parent) const {
  const bool is_first = parent ? sign_ < 0.0 : sign_ > 0.0;
  return is_first ? 1 : second_.body && parent ? 2 : 0;
}

dJointID JointLink::attached(dJointID id, dJointFeedback& feedback) const {
  dJointAttach(id, first_.id(), second_.id());
  dJointSetFeedback(id, &feedback);
  return id;
}

void JointLink::make(dWorldID world, const Options& options) {
  const Pose X_WP = parent_.pose(), X_WC = child_.pose();
  const Pose X_WF = X_WP * joint_->X_PF, X_WM = X_WC * joint_->X_CM;
  // What needs no rounding: the origin of the child where the joint is there.
  const Vec3 at = joint_->X_CM.p.isZero(0.0) ? X_WC.p : X_WF.p;
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
    case JointType::planar:
      return make_planar(world, options);
    case JointType::ball:
      id_ = attached(dJointCreateBall(world, nullptr), feedback_);
      dJointSetBallAnchor(id_, at.x(), at.y(), at.z());
      return;
    case JointType::screw:
    case JointType::free:
      return;
  }
}

void JointLink::make_planar(dWorldID world, const Options&) {
  // ODE's Plane2D knows the plane z = 0 of the world only, so: two Euler angles stopped at zero, the
  // third free, and no speed along the normal.
  const Pose X_WF = parent_.pose() * joint_->X_PF, X_WM = child_.pose() * joint_->X_CM;
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
  dJointSetLMotorAxis(normal_, 0, relative_to(true), z.x(), z.y(), z.z());
  dJointSetLMotorParam(normal_, dParamVel, 0.0);
  dJointSetLMotorParam(normal_, dParamFMax, dInfinity);
}

int JointLink::own_group(int speed) const {
  switch (joint_->type) {
    case JointType::hinge:
    case JointType::slider:
      return 0;
    case JointType::cylindrical:  // ODE's first is the travel
      return speed == 1 ? 0 : dParamGroup;
    case JointType::universal:
      return (speed == 1) == (sign_ > 0.0) ? 0 : dParamGroup;
    case JointType::planar:
      return speed == 2 ? 2 * dParamGroup : -1;
    default:
      return -1;
  }
}

void JointLink::set_stops() {
  for (int i = 0; i < speed_count(joint_->type); ++i) {
    const int group = own_group(i);
    if (group < 0 || !has_axis(*joint_, i)) continue;
    const JointAxis& axis = joint_->axes[static_cast<std::size_t>(i)];
    if (!axis.has_limit()) continue;
    const double lower = axis.lower - reference_[i], upper = axis.upper - reference_[i];
    set_param(id_, dParamLoStop + group, std::isinf(lower) ? -dInfinity : lower);
    set_param(id_, dParamHiStop + group, std::isinf(upper) ? dInfinity : upper);
  }
}

JointLink::Motor& JointLink::add_motor(dWorldID world, int speed, bool own) {
  Motor& motor = motors_.emplace_back();
  motor.speed = speed;
  motor.limited =
      has_axis(*joint_, speed) && joint_->axes[static_cast<std::size_t>(speed)].has_limit();
  if (own) {
    motor.own = true;
    motor.id = id_;
    motor.group = own_group(speed);
    return motor;
  }
  // Of the universal's axes the first is F's, the second M's; all others belong to both or to F.
  const bool of_parent =
      joint_->type == JointType::planar || (joint_->type == JointType::universal && speed == 0);
  const Pose X_WF = parent_.pose() * joint_->X_PF, X_WM = child_.pose() * joint_->X_CM;
  const Vec3 d = sign_ * cleaned(direction(speed, X_WF, X_WM));
  const int relative = of_parent                              ? relative_to(true)
                       : joint_->type == JointType::universal ? relative_to(false)
                                                              : 1;
  if (turns(speed)) {
    motor.id = attached(dJointCreateAMotor(world, nullptr), motor.feedback);
    dJointSetAMotorNumAxes(motor.id, 1);
    dJointSetAMotorAxis(motor.id, 0, relative, d.x(), d.y(), d.z());
  } else {
    motor.id = attached(dJointCreateLMotor(world, nullptr), motor.feedback);
    dJointSetLMotorNumAxes(motor.id, 1);
    dJointSetLMotorAxis(motor.id, 0, relative, d.x(), d.y(), d.z());
  }
  return motor;
}

void JointLink::add_motors(dWorldID world, const SceneModel& model, int joint,
                           const Options& options) {
  if (joint_->type == JointType::ball) return add_ball_motors(world);
  const int speeds = speed_count(joint_->type);
  bool taken[6] = {false};
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const cogrsim::Motor& asked = model.motors[m];
    if (asked.removed || asked.joint != joint || asked.axis < 0 || asked.axis >= speeds) continue;
    const bool source = asked.mode == MotorMode::velocity || asked.mode == MotorMode::position;
    const bool own = source && own_group(asked.axis) >= 0 && !taken[asked.axis];
    taken[asked.axis] = taken[asked.axis] || own;
    add_motor(world, asked.axis, own).drive = static_cast<int>(m);
  }
  for (int i = 0; i < speeds; ++i) {
    if (!has_axis(*joint_, i)) continue;
    const JointAxis& axis = joint_->axes[static_cast<std::size_t>(i)];
    if (axis.friction > 0.0) {
      // Where there are stops ODE would take the friction for a push into them.
      Motor& motor = add_motor(world, i, own_group(i) >= 0 && !taken[i] && !axis.has_limit());
      motor.friction = true;
      set(motor, 0.0, axis.friction, options.cfm);
    }
    if (axis.stiffness > 0.0 || axis.damping > 0.0) add_motor(world, i, false);
  }
}

void JointLink::add_ball_motors(dWorldID world) {
  if (joint_->axes.empty()) return;
  const JointAxis& axis = joint_->axes.front();
  const auto add = [&](dJointFeedback& feedback) {
    const dJointID id = attached(dJointCreateAMotor(world, nullptr), feedback);
    dJointSetAMotorNumAxes(id, 3);
    for (int i = 0; i < 3; ++i) {
      dJointSetAMotorAxis(id, i, 0, i == 0, i == 1, i == 2);
    }
    return id;
  };
  if (axis.stiffness > 0.0 || axis.damping > 0.0) {
    ball_law_ = add(law_feedback_);
    for (int i = 0; i < 3; ++i)
      dJointSetAMotorParam(ball_law_, dParamFMax + i * dParamGroup, dInfinity);
  }
  if (axis.friction > 0.0) {
    ball_friction_ = add(friction_feedback_);
    for (int i = 0; i < 3; ++i)
      dJointSetAMotorParam(ball_friction_, dParamFMax + i * dParamGroup, axis.friction);
  }
}

void JointLink::set(Motor& motor, double velocity, double bound, double cfm) {
  if (std::isinf(bound)) bound = motor.own && motor.limited ? kStrongest : dInfinity;
  if (velocity != motor.velocity) set_param(motor.id, dParamVel + motor.group, velocity);
  if (bound != motor.bound) set_param(motor.id, dParamFMax + motor.group, bound);
  if (cfm != motor.cfm) set_param(motor.id, dParamCFM + motor.group, cfm);
  motor.velocity = velocity;
  motor.bound = bound;
  motor.cfm = cfm;
}

void JointLink::set_law(Motor& motor, const Drive& law, double h, double* q) {
  if (law.is_speed_source()) return set(motor, law.velocity, law.max_effort, cfm_);
  // effort = bias + kp (position - q1) + kd (velocity - u1) with q1 = q + h u1 is, solved for u1,
  // u1 = v - cfm effort, which is what ODE makes of a motor:
  //   cfm = 1 / (kd + h kp),  v = cfm (bias + kp (position - q) + kd velocity)
  const double stiff = law.kd + h * law.kp;
  if (stiff <= 0.0) {
    set(motor, 0.0, 0.0, cfm_);
    apply(motor.speed, motor.drive, std::clamp(law.bias, -law.max_effort, law.max_effort));
    return;
  }
  if (law.kp > 0.0 && !fresh_) {
    update(q);
    fresh_ = true;
  }
  const double away = law.kp > 0.0 ? law.position - q[motor.speed] : 0.0;
  set(motor, (law.bias + law.kp * away + law.kd * law.velocity) / stiff, law.max_effort,
      1.0 / stiff);
}

double JointLink::stop_effort(const Motor& motor) const {
  if (!motor.limited || motor.bound <= 0.0) return 0.0;
  const double at = coordinate(id_, motor.group);
  const bool low = at <= stop_of(id_, dParamLoStop + motor.group);
  const bool high = !low && at >= stop_of(id_, dParamHiStop + motor.group);
  if (!low && !high) return 0.0;
  return motor.velocity > 0.0 || (motor.velocity == 0.0 && high) ? motor.bound : -motor.bound;
}

void JointLink::apply(int speed, int drive, double effort) {
  if (effort == 0.0) return;
  if (applied_.empty()) {
    X_WF_ = parent_.pose() * joint_->X_PF;
    X_WM_ = child_.pose() * joint_->X_CM;
  }
  applied_.push_back({speed, drive, effort});
  const Vec3 d = effort * direction(speed, X_WF_, X_WM_), at = X_WM_.p;
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

void JointLink::drive(double h, const std::vector<Drive>& drives, double* q) {
  applied_.clear();
  if (!id_) return;
  fresh_ = false;
  for (Motor& motor : motors_) {
    if (motor.drive >= 0) {
      set_law(motor, drives[static_cast<std::size_t>(motor.drive)], h, q);
    } else if (!motor.friction) {
      const JointAxis& axis = joint_->axes[static_cast<std::size_t>(motor.speed)];
      Drive law;
      law.kp = axis.stiffness;
      law.position = axis.rest;
      law.kd = axis.damping;
      set_law(motor, law, h, q);
    }
    if (motor.own && motor.limited) motor.at_stop = stop_effort(motor);
  }
  if (ball_law_ || ball_friction_) drive_ball(h);
}

void JointLink::drive_ball(double h) {
  const JointAxis& axis = joint_->axes.front();
  const Pose X_WF = parent_.pose() * joint_->X_PF, X_WM = child_.pose() * joint_->X_CM;
  if (ball_law_) {
    const double stiff = axis.damping + h * axis.stiffness;
    const Vec3 away = X_WF.q * rotation_vector(X_WF.q.conjugate() * X_WM.q);
    for (int i = 0; i < 3; ++i) {
      const int group = i * dParamGroup;
      dJointSetAMotorParam(ball_law_, dParamVel + group, -sign_ * axis.stiffness * away[i] / stiff);
      dJointSetAMotorParam(ball_law_, dParamCFM + group, 1.0 / stiff);
    }
  }
  if (ball_friction_) {
    // A bound for each of three directions: the first is that of the turning.
    const Vec3 w = child_.twist().angular - parent_.twist().angular;
    const Vec3 a = w.norm() > 1e-9 ? Vec3(w.normalized()) : Vec3(X_WF.q * Vec3::UnitX());
    const Vec3 b = a.unitOrthogonal(), c = a.cross(b);
    int i = 0;
    for (const Vec3& d : {a, b, c})
      dJointSetAMotorAxis(ball_friction_, i++, 0, d.x(), d.y(), d.z());
  }
}

void JointLink::update(double* q) const {
  double previous[7];
  std::copy(q, q + position_count(joint_->type), previous);
  joint_position(*joint_, relative_pose(*joint_, parent_.pose(), child_.pose()), previous, q);
}

void JointLink::velocities(const double* q, double* u) const {
  const Pose X_WP = parent_.pose(), X_WC = child_.pose();
  joint_velocity(*joint_, relative_pose(*joint_, X_WP, X_WC),
                 relative_twist(*joint_, X_WP, parent_.twist(), X_WC, child_.twist()), q, u);
}

Vec3 JointLink::direction(int speed, const Pose& X_WF, const Pose& X_WM) const {
  switch (joint_->type) {
    case JointType::universal:
      return speed == 0 ? Vec3(X_WF.q * Vec3::UnitX()) : Vec3(X_WM.q * Vec3::UnitY());
    case JointType::planar:
    case JointType::ball:
      return X_WF.q * Vec3::Unit(speed);
    default:
      return (sign_ > 0.0 ? X_WM.q : X_WF.q) * Vec3::UnitZ();
  }
}

Wrench JointLink::on_child(const dJointFeedback& feedback, const Vec3& centre,
                           const Vec3& about) const {
  const Vec3 f = to_vec(feedback.f1);
  return {sign_ * f, sign_ * (to_vec(feedback.t1) + (centre - about).cross(f))};
}

void JointLink::report(double h, const JointReport& out) const {
  const int speeds = speed_count(joint_->type);
  std::fill(out.joint_efforts, out.joint_efforts + speeds, 0.0);
  *out.reaction = {};
  if (!id_) return;
  const Pose X_WF = parent_.pose_before(h) * joint_->X_PF;
  const Pose X_WM = child_.pose_before(h) * joint_->X_CM;
  const Vec3 centre = first_.body->centre_before(h), about = X_WM.p;
  const auto add = [&](const Wrench& wrench) {
    out.reaction->force += wrench.force;
    out.reaction->torque += wrench.torque;
  };
  const auto along = [&](const Wrench& wrench, int speed) {
    return (turns(speed) ? wrench.torque : wrench.force).dot(direction(speed, X_WF, X_WM));
  };
  const auto credit = [&](int speed, int drive, double effort) {
    out.joint_efforts[speed] += effort;
    if (drive >= 0) out.motor_efforts[drive] += effort;
  };
  const Wrench main = on_child(feedback_, centre, about);
  add(main);
  if (normal_) add(on_child(normal_feedback_, centre, about));
  for (int i = 0; i < speeds; ++i) {
    if (own_group(i) >= 0) out.joint_efforts[i] = along(main, i);
  }
  for (const Motor& motor : motors_) {
    if (!motor.own) {
      const Wrench wrench = on_child(motor.feedback, centre, about);
      add(wrench);
      credit(motor.speed, motor.drive, motor.bound > 0.0 ? along(wrench, motor.speed) : 0.0);
    } else if (motor.at_stop != 0.0) {
      credit(motor.speed, motor.drive, motor.at_stop);
      const Vec3 e = motor.at_stop * direction(motor.speed, X_WF, X_WM);
      add(turns(motor.speed) ? Wrench{Vec3::Zero(), e} : Wrench{e, Vec3::Zero()});
    } else if (motor.drive >= 0) {
      out.motor_efforts[motor.drive] += along(main, motor.speed);
    }
  }
  for (const dJointID id : {ball_law_, ball_friction_}) {
    if (!id) continue;
    const Wrench wrench =
        on_child(id == ball_law_ ? law_feedback_ : friction_feedback_, centre, about);
    add(wrench);
    for (int i = 0; i < 3; ++i) out.joint_efforts[i] += along(wrench, i);
  }
  for (const Applied& applied : applied_) {
    credit(applied.speed, applied.drive, applied.effort);
    const Vec3 e = applied.effort * direction(applied.speed, X_WF_, X_WM_);
    add(turns(applied.speed) ? Wrench{Vec3::Zero(), e} : Wrench{e, Vec3::Zero()});
  }
}

}  // namespace cogrsim::ode
