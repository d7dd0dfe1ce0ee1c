// The motors and sensors of a run.
#pragma once

#include <vector>

#include "sensing/frame_sensor_context.h"
#include "sensing/sensor_suite.h"
#include "simulation/clock.h"
#include "simulation/element_signals.h"
#include "simulation/frame_source.h"
#include "simulation/message_log.h"
#include "simulation/motor_law.h"
#include "simulation/world_host.h"

namespace cogrsim {

class DeviceManager {
 public:
  /// Part of snapshots.
  struct Saved {
    std::vector<MotorState> motors;
    std::vector<SensorMemory> sensors;
  };
  /// Numbers of motors and sensors.
  struct Counts {
    std::size_t motors = 0, sensors = 0;
  };

  /// The arguments must outlive this object.
  DeviceManager(PluginLoader& loader, WorldHost& host, const Clock& clock)
      : loader_(loader), host_(host), clock_(clock), sensing_(loader) {}

  /// Creates the devices of the model beyond the `first` ones, which are unchanged.
  std::vector<Diagnostic> build(const Counts& first);
  Counts counts() const { return {motors_.size(), sensors_.size()}; }
  /// Switches off the sensors from index `first` on permanently.
  void retire_sensors(std::size_t first);
  /// Switches off the sensors of removed elements; `free` also releases their memory.
  void drop_removed(bool free);

  const MotorState& motor(int motor) const { return motors_[motor]; }
  const std::vector<MotorState>& motors() const { return motors_; }
  /// Sets a target within the limits of the motor, which no longer follows a signal. Precondition:
  /// finite.
  void set_target(int motor, double target);
  /// Sets the targets of the motors that follow a signal; a value that is not finite leaves the target
  /// as it is. No cost in a scene without such motors.
  void follow_signals(FrameSource& frames);
  /// Motors that move stop: targets become zero, and position motors hold.
  void stop(const std::vector<int>& motors);
  /// The drives of a step that begins in the current state.
  const std::vector<Drive>& make_drives();

  SensorSuite& sensors() { return sensors_; }
  const SensorSuite& sensors() const { return sensors_; }
  /// Measures with the sensors that are due.
  void read_sensors(FrameSource& frames, MessageLog& log);

  Saved save() const { return {motors_, sensors_.save()}; }
  void restore(const Saved& saved);

 private:
  PluginLoader& loader_;
  WorldHost& host_;
  const Clock& clock_;
  std::vector<MotorState> motors_;
  ElementSignals target_signals_;
  std::vector<Drive> drives_;
  SensorSuite sensors_;
  FrameSensorContext sensing_;
};

}  // namespace cogrsim
