#include "joint_rows.h"

#include <algorithm>
#include <cmath>

#include "convert.h"

namespace cogrsim::ode {

namespace {

// A spring is taken where the step starts up to this product of gain, h^2 and inverse inertia, which
// keeps its energy (symplectic Euler, stable up to 4), and where it ends beyond.
constexpr double kSoftSpring = 0.25;
// What a joint is apart at the start is closed at this speed at most [m/s], [rad/s].
constexpr double kClosingSpeed = 0.2;
// A coordinate beyond its limit comes back by this part of the way per step, at this speed at most.
constexpr double kLimitRecovery = 0.2;
constexpr double kLimitSpeed = 1.0;
// Softness of rows that others may contradict (two speed sources on one axis), against the speed
// that one newton gives in one step.
constexpr double kHardness = 1e-9;

/// Weight of the speed at the end of the step so that a damper decays exactly as exp(-x).
double damping_share(double x) {
  if (x < 1e-3) return 0.5 + x / 12.0;
  return 1.0 / (1.0 - std::exp(-x)) - 1.0 / x;
}

/// `end` without the part of the `start` that is too much to be closed in this step.
Vec3 closable(const Vec3& end, const Vec3& start, double h) {
  const double gap = start.norm(), most = kClosingSpeed * h;
  return gap <= most ? end : Vec3(end - start * (1.0 - most / gap));
}

/// How far M is turned against what the joint allows, along the directions of its angular rows.
int turned(const Joint& joint, const Pose& F, const Pose& M, Vec3* d, double* error) {
  const Mat3 R_F = F.q.toRotationMatrix(), R_M = M.q.toRotationMatrix();
  switch (joint.type) {
    case JointType::fixed:
    case JointType::slider: {
      const Vec3 phi = rotation_vector(F.q.conjugate() * M.q);
      for (int i = 0; i < 3; ++i) {
        d[i] = R_F.col(i);
        error[i] = phi[i];
      }
      return 3;
    }
    case JointType::hinge:
    case JointType::screw:
    case JointType::cylindrical:
    case JointType::planar: {
      const Vec3 aside = R_F.transpose() * R_F.col(2).cross(R_M.col(2));
      for (int i = 0; i < 2; ++i) {
        d[i] = R_F.col(i);
        error[i] = aside[i];
      }
      return 2;
    }
    case JointType::universal:
      d[0] = R_F.col(0).cross(R_M.col(1)).normalized();
      error[0] = -R_F.col(0).dot(R_M.col(1));
      return 1;
    case JointType::ball:
    case JointType::free:
      return 0;
  }
  return 0;
}

}  // namespace

Vec3 JointStep::direction(int axis) const {
  const Mat3 R_F = X_WF_.q.toRotationMatrix();
  switch (joint_->type) {
    case JointType::universal:
      return axis == 0 ? Vec3(R_F.col(0)) : Vec3(X_WM_.q * Vec3::UnitY());
    case JointType::planar:
      return R_F.col(axis);
    case JointType::ball:
      return ball_[axis];
    default:
      return R_F.col(2);
  }
}

void JointStep::begin(const SceneModel& model, int joint, const Pose& X_WP, const Pose& X_WC,
                      const Twist& V_WP, const Twist& V_WC, const double* q) {
  index_ = joint;
  joint_ = &model.joints[static_cast<std::size_t>(joint)];
  X_WF_ = X_WP * joint_->X_PF;
  X_WM_ = X_WC * joint_->X_CM;
  const Pose X_FM = relative_pose(*joint_, X_WP, X_WC);
  joint_position(*joint_, X_FM, q, q_);
  joint_velocity(*joint_, X_FM, relative_twist(*joint_, X_WP, V_WP, X_WC, V_WC), q_, u_);
  pushes_.clear();
  laws_.clear();
  holds_.clear();
}

void JointStep::form_laws(const SceneModel& model, const std::vector<int>& motors,
                          const std::vector<Drive>& drives, double h, const RowBody& parent,
                          const RowBody& child) {
  const JointType type = joint_->type;
  if (type == JointType::fixed || type == JointType::free) return;
  const int speeds = speed_count(type);
  double q[3] = {q_[0], q_[1], q_[2]}, u[3] = {u_[0], u_[1], u_[2]};
  if (type == JointType::ball) {
    // Along the motion and across it, so that dry friction is a circle about what moves.
    const Vec3 phi = X_WF_.q * rotation_vector(Quat(q_[0], q_[1], q_[2], q_[3]));
    const Vec3 w = X_WF_.q * Vec3(u_[0], u_[1], u_[2]);
    const double speed = w.norm();
    ball_[0] = speed > 1e-9 ? Vec3(w / speed) : Vec3(X_WF_.q * Vec3::UnitX());
    perpendiculars(ball_[0], ball_[1], ball_[2]);
    for (int i = 0; i < 3; ++i) {
      q[i] = phi.dot(ball_[i]);
      u[i] = w.dot(ball_[i]);
    }
    const JointAxis& cone = joint_->axes.front();
    const double angle = phi.norm();
    if (cone.upper < kNoBound && angle > 1e-9) {
      const Vec3 d = phi / angle;
      const double left = cone.upper - angle, rate = d.dot(w);
      if (left < 0.05 + 2.0 * h * std::abs(rate)) {
        LawRow row;
        row.one_sided = true;
        row.d = d;
        row.sign = -1.0;
        row.target = left >= 0.0 ? -left / h : std::min(-left * kLimitRecovery / h, kLimitSpeed);
        laws_.push_back(row);
      }
    }
  }
  for (int axis = 0; axis < speeds; ++axis) {
    const JointAxis& law =
        joint_->axes[type == JointType::ball ? 0 : static_cast<std::size_t>(axis)];
    const Vec3 d = direction(axis);
    double inverse = 0.0;  // of the inertia felt along the axis, other joints left out: too large
    for (const RowBody* body : {&parent, &child}) {
      if (angular(axis)) {
        inverse += d.dot(body->inverse_inertia * d);
      } else {
        const Vec3 arm = (X_WM_.p - body->c).cross(d);
        inverse += body->inverse_mass + arm.dot(body->inverse_inertia * arm);
      }
    }
    const double unit = h * inverse;  // speed that an effort of one gives in a step
    // offset - slope u1 is the effort at the speed u1 of the end.
    const auto place = [&](double bias, double kp, double position, double kd, double velocity,
                           double& offset, double& slope) {
      offset = bias + kp * (position - q[axis]);
      slope = 0.0;
      if (kp * h * unit > kSoftSpring) {
        slope = kd + h * kp;
        offset += kd * velocity;
      } else if (kd > 0.0) {
        const double share = damping_share(kd * unit);
        slope = share * kd;
        offset += kd * (velocity - (1.0 - share) * u[axis]);
      }
    };
    const auto put = [&](double offset, double slope, double bound, int motor) {
      if (slope <= 0.0) {
        const double effort = std::clamp(offset, -bound, bound);
        if (effort != 0.0 || motor >= 0) pushes_.push_back({axis, motor, effort});
        return;
      }
      LawRow row;
      row.axis = axis;
      row.motor = motor;
      row.d = d;
      row.target = offset / slope;
      row.cfm = 1.0 / slope;
      row.bound = bound;
      laws_.push_back(row);
    };
    double offset = 0.0, slope = 0.0;
    place(0.0, law.stiffness, type == JointType::ball ? 0.0 : law.rest, law.damping, 0.0, offset,
          slope);
    put(offset, slope, kNoBound, -1);
    if (law.friction > 0.0) {
      LawRow row;
      row.axis = axis;
      row.d = d;
      row.cfm = kHardness * unit;
      row.bound = law.friction;
      laws_.push_back(row);
    }
    for (const int m : motors) {
      const Motor& motor = model.motors[static_cast<std::size_t>(m)];
      const Drive& drive = drives[static_cast<std::size_t>(m)];
      if (motor.axis != axis || motor.removed) continue;
      if (drive.is_speed_source()) {
        LawRow row;
        row.axis = axis;
        row.motor = m;
        row.d = d;
        row.target = drive.velocity;
        row.cfm = kHardness * unit;
        row.bound = drive.max_effort;
        if (drive.max_effort > 0.0) laws_.push_back(row);
        continue;
      }
      place(drive.bias, drive.kp, drive.position, drive.kd, drive.velocity, offset, slope);
      if (drive.max_effort > 0.0) put(offset, slope, drive.max_effort, m);
    }
    if (type == JointType::ball) continue;
    for (const double side : {1.0, -1.0}) {
      const double left = side > 0.0 ? q[axis] - law.lower : law.upper - q[axis];
      if (!(left < 0.05 + 2.0 * h * std::abs(u[axis]))) continue;
      LawRow row;
      row.axis = axis;
      row.one_sided = true;
      row.sign = side;
      row.d = d;
      row.target = left >= 0.0 ? -left / h : std::min(-left * kLimitRecovery / h, kLimitSpeed);
      laws_.push_back(row);
    }
  }
}

Wrench JointStep::known() const {
  Wrench out;
  for (const Push& push : pushes_) {
    (angular(push.axis) ? out.torque : out.force) += push.effort * direction(push.axis);
  }
  return out;
}

void JointStep::ask(Rows& rows, const RowBody& parent, const RowBody& child, Closing closing,
                    const Pose& end_P, const Pose& end_C, double h, double softness) {
  // Of the speed of now, and of the gap to be closed.
  holds_.clear();
  const double speed = closing == Closing::stop ? 0.0 : 1.0;
  const double close = closing == Closing::position ? 1.0 / h : 0.0;
  const Pose F1 = end_P * joint_->X_PF, M1 = end_C * joint_->X_CM;
  const Pose &F = X_WF_, &M = X_WM_;
  const Vec3 w = child.w - parent.w;
  const Vec3 gap = M.p - F.p, gap1 = M1.p - F1.p;
  const Vec3 at = M.p;
  const Vec3 rate = child.at(at) - parent.at(at);
  const Mat3 R_F = F.q.toRotationMatrix(), R_F1 = F1.q.toRotationMatrix();
  const Vec3 aside = closable(R_F1.transpose() * gap1, R_F.transpose() * gap, h);
  // The row asks that the end of the step be where the joint wants it; it is known for the speeds
  // the bodies start from, and changes by h times what they change.
  const auto held = [&](int axis) { return speed * R_F.col(axis).dot(rate) - close * aside[axis]; };
  const double soft = softness * h * (parent.inverse_mass + child.inverse_mass);
  Vec3 d[3];
  double target[3];
  switch (joint_->type) {
    case JointType::fixed:
    case JointType::hinge:
    case JointType::universal:
    case JointType::ball:
      rows.point(parent, child, F.p, at,
                 speed * (child.at(at) - parent.at(F.p)) - close * closable(gap1, gap, h), softness,
                 holds_);
      break;
    case JointType::slider:
    case JointType::cylindrical:
    case JointType::screw:
      for (int i = 0; i < 2; ++i) {
        d[i] = R_F.col(i);
        target[i] = held(i);
      }
      holds_.push_back(rows.along(parent, child, at, 2, d, target, kNoBound, soft));
      break;
    case JointType::planar:
      d[0] = R_F.col(2);
      target[0] = held(2);
      holds_.push_back(rows.along(parent, child, at, 1, d, target, kNoBound, soft));
      break;
    case JointType::free:
      return;
  }
  double error[3] = {}, error1[3] = {};
  Vec3 unused[3];
  const int turns = turned(*joint_, F, M, d, error);
  if (turns > 0) {
    turned(*joint_, F1, M1, unused, error1);
    const Vec3 left =
        closable(Vec3(error1[0], error1[1], error1[2]), Vec3(error[0], error[1], error[2]), h);
    for (int i = 0; i < turns; ++i) target[i] = speed * d[i].dot(w) - close * left[i];
    const double soft_turn =
        softness * h * (parent.inverse_inertia + child.inverse_inertia).trace() / 3.0;
    holds_.push_back(rows.turn(parent, child, turns, d, target, kNoBound, soft_turn));
  }
  if (joint_->type == JointType::screw) {
    // Travel less pitch per radian times angle stays zero: the speed along z - k y, seen at the
    // radius 1 on the x side, is the travel's less k times the angle's.
    const double lead = joint_->pitch / (2.0 * M_PI);
    Vec3 d_s = R_F.col(2) - lead * R_F.col(1);
    const double length = d_s.norm();
    d_s /= length;
    const Vec3 beside = at + R_F.col(0);
    double q1[7];
    const double* before = q_;
    joint_position(*joint_, F1.inverse() * M1, before, q1);
    const double travel1 = R_F1.col(2).dot(gap1), travel = R_F.col(2).dot(gap);
    const double miss =
        closable(Vec3(travel1 - lead * q1[0], 0, 0), Vec3(travel - lead * q_[0], 0, 0), h).x();
    const double now = d_s.dot(child.at(beside) - parent.at(beside));
    const double wanted = speed * now - close * miss / length;
    holds_.push_back(rows.along(parent, child, beside, 1, &d_s, &wanted, kNoBound, soft));
  }
  for (LawRow& law : laws_) {
    const Vec3 signed_d = law.sign * law.d;
    if (law.one_sided) {
      law.handle = angular(law.axis) ? rows.stop_turn(parent, child, signed_d, law.target)
                                     : rows.stop_along(parent, child, at, signed_d, law.target);
    } else if (angular(law.axis)) {
      law.handle = rows.turn(parent, child, 1, &law.d, &law.target, law.bound, law.cfm);
    } else {
      law.handle = rows.along(parent, child, at, 1, &law.d, &law.target, law.bound, law.cfm);
    }
  }
}

void JointStep::report(const Rows& rows, const RowBody& parent, const RowBody& child,
                       std::vector<double>& joint_efforts, std::vector<double>& motor_efforts,
                       Wrench& reaction) const {
  Wrench along = known();
  for (const Push& push : pushes_) {
    if (push.motor >= 0) motor_efforts[static_cast<std::size_t>(push.motor)] += push.effort;
  }
  const auto add = [](Wrench& sum, const Wrench& more) {
    sum.force += more.force;
    sum.torque += more.torque;
  };
  for (const LawRow& law : laws_) {
    const Wrench got = rows.wrench(law.handle, parent, child, X_WM_.p);
    add(along, got);
    if (law.motor < 0) continue;
    motor_efforts[static_cast<std::size_t>(law.motor)] +=
        law.d.dot(angular(law.axis) ? got.torque : got.force);
  }
  double* efforts = joint_efforts.data() + joint_->speed_offset;
  if (joint_->type == JointType::ball) {
    const Vec3 torque = X_WF_.q.conjugate() * along.torque;
    std::copy(torque.data(), torque.data() + 3, efforts);
  } else if (joint_->type != JointType::free) {
    for (int axis = 0; axis < speed_count(joint_->type); ++axis) {
      efforts[axis] = direction(axis).dot(angular(axis) ? along.torque : along.force);
    }
  }
  reaction = along;
  for (const int handle : holds_) add(reaction, rows.wrench(handle, parent, child, X_WM_.p));
}

}  // namespace cogrsim::ode
