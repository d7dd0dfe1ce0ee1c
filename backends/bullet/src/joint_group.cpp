#include "joint_group.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cogrsim::bullet {

bool acts(const Drive& drive) { return drive.kd != 0.0 || drive.kp != 0.0 || drive.bias != 0.0; }

namespace {

void fill_whole_axis(AxisLaw& law, const JointAxis& model, const AxisState& state,
                     const std::vector<int>& motors, const std::vector<Drive>& drives) {
  law.clear();
  for (const int m : motors) law.add(drive_element(drives[static_cast<std::size_t>(m)], state));
  if (model.stiffness > 0.0 || model.damping > 0.0) law.add(spring_damper_element(model, state));
  if (model.friction > 0.0) law.add(friction_element(model.friction, state.dt));
  if (std::isfinite(model.lower)) law.add(lower_limit_element(model.lower, state));
  if (std::isfinite(model.upper)) law.add(upper_limit_element(model.upper, state));
}

}  // namespace

void fill_axis_law(AxisLaw& law, AxisPart part, const JointAxis& model, const AxisState& state,
                   const std::vector<int>& motors, const std::vector<Drive>& drives) {
  switch (part) {
    case AxisPart::whole:
      fill_whole_axis(law, model, state, motors, drives);
      break;
    case AxisPart::ball_spring: {
      JointAxis spring = model;
      spring.lower = -std::numeric_limits<double>::infinity();
      spring.upper = -spring.lower;
      spring.rest = 0.0;
      fill_whole_axis(law, spring, state, {}, drives);
      break;
    }
    case AxisPart::ball_cone:
      law.clear();
      law.add(upper_limit_element(model.upper, state));
      break;
  }
}

std::vector<std::vector<int>> motors_of(const SceneModel& model, int joint) {
  std::vector<std::vector<int>> out(model.joints[static_cast<std::size_t>(joint)].axes.size());
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const Motor& motor = model.motors[m];
    if (motor.joint == joint && !motor.removed) {
      out[static_cast<std::size_t>(motor.axis)].push_back(static_cast<int>(m));
    }
  }
  return out;
}

}  // namespace cogrsim::bullet
