#include "model/motor_limits.h"

#include <algorithm>

#include "core/index.h"

namespace cogrsim {

namespace {

double within(double value, double bound) { return std::clamp(value, -bound, bound); }

}  // namespace

const JointAxis* driven_axis(const SceneModel& model, const Motor& motor) {
  const Joint& joint = model.joints[at(motor.joint)];
  return at(motor.axis) < joint.axes.size() ? &joint.axes[at(motor.axis)] : nullptr;
}

double motor_max_effort(const SceneModel& model, const Motor& motor) {
  const JointAxis* axis = driven_axis(model, motor);
  return axis ? std::min(motor.max_effort, axis->max_effort) : motor.max_effort;
}

double motor_max_speed(const SceneModel& model, const Motor& motor) {
  const JointAxis* axis = driven_axis(model, motor);
  return axis ? std::min(motor.max_speed, axis->max_speed) : motor.max_speed;
}

EffortLimits limits_on_curve(double stall_effort, double no_load_speed, double most, double speed) {
  const auto left = [&](double along) {
    return std::clamp(stall_effort * (1.0 - along / no_load_speed), 0.0, most);
  };
  return {left(speed), left(-speed)};
}

EffortLimits effort_limits(const SceneModel& model, const Motor& motor, double speed) {
  const double most = motor_max_effort(model, motor);
  if (!has_curve(motor)) return {most, most};
  return limits_on_curve(motor.stall_effort, motor.no_load_speed, most, speed);
}

double clamp_target(const SceneModel& model, const Motor& motor, double target) {
  target = std::max(motor.min_target, std::min(target, motor.max_target));
  switch (motor.mode) {
    case MotorMode::velocity:
      return within(target, motor_max_speed(model, motor));
    case MotorMode::torque:
      return within(target, motor_max_effort(model, motor));
    case MotorMode::dc:
      return within(target, motor.max_voltage);
    case MotorMode::position:
    case MotorMode::servo: {
      const JointAxis* axis = driven_axis(model, motor);
      return axis ? std::clamp(target, axis->lower, axis->upper) : target;
    }
  }
  return target;
}

int motor_position_index(const SceneModel& model, const Motor& motor) {
  return model.joints[at(motor.joint)].position_offset + motor.axis;
}

int motor_speed_index(const SceneModel& model, const Motor& motor) {
  return model.joints[at(motor.joint)].speed_offset + motor.axis;
}

}  // namespace cogrsim
