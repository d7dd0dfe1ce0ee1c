#include "drives.h"

#include <algorithm>
#include <cmath>

#include "mechanism/loops.h"

namespace cogrsim::dynamics {
namespace {

constexpr double kExplicitLimit = 0.5;

void locate(const Mechanism& mechanism, AxisLaw& law) {
  const Link& link = mechanism.links()[std::size_t(mechanism.joint_link(law.joint))];
  law.component = link.component;
  law.local = law.speed - mechanism.components()[std::size_t(law.component)].speeds.first;
}

}  // namespace

double AxisLaw::coordinate(const Values& q) const {
  return ball_axis < 0 ? q[position] : rotation_vector(q, position)[ball_axis];
}

double AxisLaw::effort_at(const Values& q, const Values& u) const {
  double wanted = law.bias;
  if (law.kp > 0.0) wanted += law.kp * (law.position - coordinate(q));
  if (law.kd > 0.0) wanted += law.kd * (law.velocity - u[speed]);
  return std::clamp(wanted, -law.max_effort, law.max_effort);
}

Vec3 rotation_vector(const Values& q, int first) {
  const double sign = q[first] < 0 ? -1.0 : 1.0;
  const Vec3 v(sign * q[first + 1], sign * q[first + 2], sign * q[first + 3]);
  const double s = v.norm();
  const double angle = 2.0 * std::atan2(s, sign * q[first]);
  return s > 1e-12 ? Vec3(v * (angle / s)) : Vec3(2.0 * v);
}

std::vector<AxisLaw> make_laws(const Mechanism& mechanism) {
  const SceneModel& model = mechanism.model();
  std::vector<AxisLaw> laws;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || mechanism.joint_link(int(j)) < 0) continue;
    const bool ball = joint.type == JointType::ball;
    const int count = ball ? (joint.axes.empty() ? 0 : 3) : int(joint.axes.size());
    for (int a = 0; a < count; ++a) {
      const JointAxis& axis = joint.axes[std::size_t(ball ? 0 : a)];
      if (axis.damping <= 0.0 && axis.stiffness <= 0.0) continue;
      AxisLaw law;
      law.law.kp = axis.stiffness;
      law.law.position = ball ? 0.0 : axis.rest;
      law.law.kd = axis.damping;
      law.joint = int(j);
      law.effort = joint.speed_offset + a;
      law.speed = mechanism.axis_speed(int(j), a);
      law.position = mechanism.axis_position(int(j), ball ? 0 : a);
      law.ball_axis = ball ? a : -1;
      locate(mechanism, law);
      laws.push_back(law);
    }
  }
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const Motor& motor = model.motors[m];
    if (motor.removed || motor.joint < 0 || model.joints[std::size_t(motor.joint)].removed)
      continue;
    if (mechanism.joint_link(motor.joint) < 0) continue;
    AxisLaw law;
    law.joint = motor.joint;
    law.motor = int(m);
    law.effort = model.joints[std::size_t(motor.joint)].speed_offset + motor.axis;
    law.speed = mechanism.axis_speed(motor.joint, motor.axis);
    law.position = mechanism.axis_position(motor.joint, motor.axis);
    locate(mechanism, law);
    laws.push_back(law);
  }
  return laws;
}

double fitted_theta(double x) {
  if (x < 1e-4) return 0.5;
  return 1.0 / (1.0 - std::exp(-x)) - 1.0 / x;
}

void classify_laws(Mechanism& mechanism, const std::vector<Drive>& drives, double h,
                   std::vector<AxisLaw>& laws) {
  static thread_local std::vector<double> column;
  for (AxisLaw& law : laws) {
    if (law.motor >= 0) law.law = drives[std::size_t(law.motor)];
    if (law.law.is_speed_source()) {
      law.implicit = true;
      continue;
    }
    law.implicit = false;
    const double gain = law.law.kd * h + law.law.kp * h * h;
    if (gain <= 0.0) continue;
    Component& c = mechanism.components()[std::size_t(law.component)];
    update_component(mechanism, c);
    column.assign(std::size_t(c.size()), 0.0);
    column[std::size_t(law.local)] = 1.0;
    solve_mass(c, column.data());
    close_loops(c, column.data());
    const double x = gain * column[std::size_t(law.local)];
    law.implicit = x > kExplicitLimit;
    law.theta = fitted_theta(x);
  }
}

}  // namespace cogrsim::dynamics
