#include "simulation/motor_law.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "model/motor_limits.h"

namespace cogrsim {

namespace {

const JointAxis* axis_of(const SceneModel& model, const Motor& motor) {
  const Joint& joint = model.joints[motor.joint];
  const auto axis = static_cast<std::size_t>(motor.axis);
  return axis < joint.axes.size() ? &joint.axes[axis] : nullptr;
}

double clamp_to(double value, double bound) { return std::clamp(value, -bound, bound); }

Drive velocity_drive(double velocity, double max_effort) {
  Drive drive;
  drive.kd = kInfinity;
  drive.velocity = velocity;
  drive.max_effort = max_effort;
  return drive;
}

// Without an effort limit the motor would exert an infinite effort against a joint limit, so its
// target ends there. Beyond a joint limit it returns no faster than this speed [rad/s], [m/s].
double within_stops(double velocity, const JointAxis& axis, double q, double dt) {
  constexpr double kReturn = 1.0;
  double low = (axis.lower - q) / dt, high = (axis.upper - q) / dt;
  if (low > 0.0) low = std::min(low, kReturn);
  if (high < 0.0) high = std::max(high, -kReturn);
  return std::clamp(velocity, low, high);
}

// Constant effort up to the speed limit, which is then held: a speed source at the limit whose
// effort is limited to the target.
Drive torque_drive(double effort, double max_speed, double max_effort) {
  const double bounded = clamp_to(effort, max_effort);
  if (max_speed < kInfinity)
    return velocity_drive(std::copysign(max_speed, bounded), std::abs(bounded));
  Drive drive;
  drive.bias = bounded;
  drive.max_effort = max_effort;
  return drive;
}

Drive servo_drive(const Motor& motor, MotorState& state, double q, double last_effort, double dt,
                  double max_speed, double max_effort) {
  double error = state.acting - q;
  // Anti-windup by conditional integration: the integral does not grow while the drive is saturated
  // in the direction of the error.
  const bool saturated = std::abs(last_effort) >= max_effort * (1.0 - 1e-9);
  if (motor.ki > 0.0 && !(saturated && last_effort * error > 0.0)) state.integral += error * dt;
  // A PD drive reaches the speed kp * error / kd, so limiting the error limits the speed.
  if (max_speed < kInfinity && motor.kp > 0.0 && motor.kd > 0.0) {
    error = clamp_to(error, motor.kd * max_speed / motor.kp);
  }
  Drive drive;
  drive.kp = motor.kp;
  drive.position = q + error;
  drive.kd = motor.kd;
  drive.bias = motor.ki * state.integral;
  drive.max_effort = max_effort;
  return drive;
}

// Current i = (V - ke g u) / R, effort g kt i: the stall effort and a damping of g^2 kt ke / R.
Drive dc_drive(const Motor& motor, double voltage, double max_effort) {
  const double per_ampere = motor.gear * motor.kt;
  Drive drive;
  drive.bias = per_ampere * voltage / motor.resistance;
  drive.kd = motor.gear * per_ampere * motor.ke / motor.resistance;
  drive.max_effort = std::min(max_effort, std::abs(per_ampere) * motor.max_current);
  return drive;
}

/// Of a motor with a speed-torque curve: the limit on the side where the effort of this step will be,
/// as a Drive has one for both. `wanted` has the sign of the effort that the state asks for, 0 where
/// the load decides about it; then the motor goes on as in the last step. Where it was on the other
/// side than the state asks for, the smaller limit holds, so that no more than one step in a row has
/// an effort beyond the curve.
double limit_of_step(const EffortLimits& limits, double wanted, double last) {
  const double sign = wanted == 0.0 ? last : wanted;
  if (sign * last < 0.0) return std::min(limits.forward, limits.backward);
  return sign >= 0.0 ? limits.forward : limits.backward;
}

/// The sign of the effort that brings a joint from `speed` to `target`; 0 within a hundredth of the
/// no-load speed, where the load decides.
double towards(double target, double speed, const Motor& motor) {
  const double difference = target - speed;
  return std::abs(difference) <= 0.01 * motor.no_load_speed ? 0.0 : difference;
}

}  // namespace

void take_targets(const SceneModel& model, double time, double dt,
                  std::vector<MotorState>& motors) {
  for (std::size_t i = 0; i < model.motors.size(); ++i) {
    MotorState& state = motors[i];
    const double delay = model.motors[i].delay;
    const double newest = state.waiting.empty() ? state.acting : state.waiting.back().target;
    if (delay <= 0.0) {
      state.acting = state.target;
      continue;
    }
    if (state.target != newest) state.waiting.push_back({time, state.target});
    // A boundary counts as reached up to a millionth of a step earlier, as for rates.
    while (!state.waiting.empty() && state.waiting.front().time + delay <= time + 1e-6 * dt) {
      state.acting = state.waiting.front().target;
      state.waiting.pop_front();
    }
  }
}

MotorState initial_motor_state(const SceneModel& model, const Motor& motor) {
  MotorState state;
  const Joint& joint = model.joints[motor.joint];
  const auto axis = static_cast<std::size_t>(motor.axis);
  const bool holds = motor.mode == MotorMode::position || motor.mode == MotorMode::servo;
  const double start = holds && axis < joint.position.size() ? joint.position[axis] : 0.0;
  state.target = state.acting = clamp_target(model, motor, motor.target.value_or(start));
  return state;
}

void make_drives(const SceneModel& model, const WorldState& state, double dt,
                 std::vector<MotorState>& motors, std::vector<Drive>& drives) {
  drives.resize(model.motors.size());
  for (std::size_t i = 0; i < model.motors.size(); ++i) {
    const Motor& motor = model.motors[i];
    drives[i] = Drive{};
    if (motor.removed) continue;
    double max_effort = motor_max_effort(model, motor);
    const double max_speed = motor_max_speed(model, motor);
    const double q = state.joint_positions[motor_position_index(model, motor)];
    const double speed = state.joint_velocities[motor_speed_index(model, motor)];
    const double last = i < state.motor_efforts.size() ? state.motor_efforts[i] : 0.0;
    const double target = motors[i].acting;
    const JointAxis* axis = axis_of(model, motor);
    const auto on_curve = [&](double wanted, double before) {
      if (has_curve(motor))
        max_effort = limit_of_step(effort_limits(model, motor, speed), wanted, before);
      return max_effort;
    };
    switch (motor.mode) {
      case MotorMode::velocity:
        drives[i] = velocity_drive(target, on_curve(towards(target, speed, motor), last));
        break;
      case MotorMode::torque: {
        // Beyond its largest speed it brakes.
        const bool brakes = speed * target > 0.0 && std::abs(speed) > max_speed;
        const double wanted = brakes ? -target : target;
        drives[i] = torque_drive(target, max_speed, on_curve(wanted, wanted));
        break;
      }
      case MotorMode::position: {
        // First-order approach; a time constant below one step would overshoot.
        const double rate = (target - q) / std::max(motor.response, dt);
        const double wanted = clamp_to(rate, max_speed);
        drives[i] = velocity_drive(wanted, on_curve(towards(wanted, speed, motor), last));
        break;
      }
      case MotorMode::servo: {
        drives[i] = servo_drive(motor, motors[i], q, last, dt, max_speed, max_effort);
        const Drive& law = drives[i];
        const double wanted = law.kp * (law.position - q) + law.bias - law.kd * speed;
        drives[i].max_effort = on_curve(wanted, last);
        break;
      }
      case MotorMode::dc:
        drives[i] = dc_drive(motor, target, max_effort);
        break;
    }
    if (drives[i].is_speed_source() && max_effort == kInfinity && axis) {
      drives[i].velocity = within_stops(drives[i].velocity, *axis, q, dt);
    }
  }
}

}  // namespace cogrsim
