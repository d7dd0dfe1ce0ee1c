// The devices of a run for controllers in the process of the simulation.
#pragma once

#include "assembly/device_port.h"
#include "model/motor_limits.h"
#include "simulation/device_manager.h"

namespace cogrsim {

class LocalDevices final : public DevicePort {
 public:
  /// The arguments must outlive this object.
  LocalDevices(PluginLoader& loader, WorldHost& host, DeviceManager& devices, const Clock& clock,
               MessageLog& log)
      : loader_(loader), host_(host), devices_(devices), clock_(clock), log_(log) {}

  double time() const override { return clock_.time(); }
  const SceneModelPtr& model() const override { return host_.model(); }
  const SceneModelPtr& original() const override { return host_.original(); }
  PluginLoader& loader() override { return loader_; }

  double target(int motor) const override { return devices_.motor(motor).target; }
  void set_target(int motor, double target) override { devices_.set_target(motor, target); }
  double effort(int motor) override { return host_.state().motor_efforts[index(motor)]; }
  double joint_position(int motor) override {
    const int coordinate = motor_position_index(*model(), model()->motors[index(motor)]);
    return host_.state().joint_positions[index(coordinate)];
  }
  double joint_velocity(int motor) override {
    const int speed = motor_speed_index(*model(), model()->motors[index(motor)]);
    return host_.state().joint_velocities[index(speed)];
  }

  const Reading& reading(int sensor) const override {
    return devices_.sensors().reading(index(sensor));
  }
  void enable(int sensor, bool on) override { devices_.sensors().enable(index(sensor), on); }

  void report(const std::string& source, const std::string& message) override {
    log_.report(Severity::note, source, message);
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  PluginLoader& loader_;
  WorldHost& host_;
  DeviceManager& devices_;
  const Clock& clock_;
  MessageLog& log_;
};

}  // namespace cogrsim
