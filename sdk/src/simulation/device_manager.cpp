#include "simulation/device_manager.h"

#include <cmath>

#include "core/index.h"
#include "model/motor_limits.h"

namespace cogrsim {

std::vector<Diagnostic> DeviceManager::build(const Counts& first) {
  const SceneModelPtr& model = host_.model();
  motors_.resize(first.motors);
  for (std::size_t i = first.motors; i < model->motors.size(); ++i) {
    motors_.push_back(initial_motor_state(*model, model->motors[i]));
  }
  return sensors_.build(model, host_.seed(), loader_, clock_.dt(), first.sensors);
}

void DeviceManager::retire_sensors(std::size_t first) {
  for (std::size_t i = first; i < sensors_.size(); ++i) sensors_.retire(i);
}

void DeviceManager::drop_removed(bool free) {
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (!host_.model()->sensors[i].removed) continue;
    if (free) {
      sensors_.retire(i);
    } else {
      sensors_.enable(i, false);
    }
  }
}

void DeviceManager::set_target(int motor, double target) {
  const SceneModel& model = *host_.model();
  motors_[at(motor)].target = clamp_target(model, model.motors[at(motor)], target);
  motors_[at(motor)].follows = false;
}

void DeviceManager::follow_signals(FrameSource& frames) {
  const SceneModelPtr& model = host_.model();
  target_signals_.resolve(model, model->motors, &Motor::target_signal,
                          [this](int sensor) { return &sensors_.channels(at(sensor)); });
  if (!target_signals_.any()) return;
  // Controllers have published since the frame of this step was made.
  const std::shared_ptr<Frame> frame = frames.latest(target_signals_.needs());
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const Motor& motor = model->motors[i];
    if (motor.target_signal.empty() || motor.removed || !motors_[i].follows) continue;
    const double target = target_signals_.evaluate(i, *frame);
    if (std::isfinite(target)) motors_[i].target = clamp_target(*model, motor, target);
  }
}

void DeviceManager::stop(const std::vector<int>& motors) {
  for (const int motor : motors) {
    motors_[at(motor)].follows = false;
    const MotorMode mode = host_.model()->motors[at(motor)].mode;
    if (mode == MotorMode::position || mode == MotorMode::servo) continue;
    motors_[at(motor)].target = 0.0;
  }
}

const std::vector<Drive>& DeviceManager::make_drives() {
  const SceneModel& model = *host_.model();
  if (!model.motors.empty()) {
    take_targets(model, clock_.time(), clock_.dt(), motors_);
    cogrsim::make_drives(model, host_.state(), clock_.dt(), motors_, drives_);
  }
  return drives_;
}

void DeviceManager::read_sensors(FrameSource& frames, MessageLog& log) {
  const auto needed = sensors_.begin(clock_.time(), clock_.dt());
  if (!needed) return;
  sensing_.show(frames.frame_with(*needed));
  for (const SensorFault& fault : sensors_.read(sensing_)) {
    const std::string& name = host_.model()->sensors[at(fault.sensor)].name;
    log.report(Severity::error, name,
               "sensor '" + name + "' cannot measure: " + fault.error.text());
  }
  sensing_.hide();
}

void DeviceManager::restore(const Saved& saved) {
  motors_ = saved.motors;
  sensors_.restore(saved.sensors);
}

}  // namespace cogrsim
