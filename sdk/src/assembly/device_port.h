// What a controller can access of a run: the scene, its motors and sensors, and the messages.
#pragma once

#include <memory>
#include <string>

#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/loader.h"

namespace cogrsim {

/// Implemented by the simulation for controllers in its own process, and in the process of an
/// isolated controller by a copy of the devices. Motors and sensors are indices into the model.
class DevicePort {
 public:
  virtual ~DevicePort() = default;

  virtual double time() const = 0;                    ///< simulated time [s], for crash reports
  virtual const SceneModelPtr& model() const = 0;     ///< the current scene
  virtual const SceneModelPtr& original() const = 0;  ///< the initial scene, with the seed
  virtual PluginLoader& loader() = 0;

  virtual double target(int motor) const = 0;  ///< in the unit of the mode of the motor
  /// Sets the target from the next step on, within the limits of the motor. Precondition: finite.
  virtual void set_target(int motor, double target) = 0;
  /// At the end of the last step: mean effort [N m] or [N], and the driven coordinate [rad] or [m]
  /// with its speed.
  virtual double effort(int motor) = 0;
  virtual double joint_position(int motor) = 0;
  virtual double joint_velocity(int motor) = 0;

  /// The latest reading; the reference is valid until the next step.
  virtual const Reading& reading(int sensor) const = 0;
  virtual void enable(int sensor, bool on) = 0;

  /// Publishes a message of a controller.
  virtual void report(const std::string& source, const std::string& message) = 0;
};

}  // namespace cogrsim
