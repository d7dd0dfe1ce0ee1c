// The interface of a controller to its assembly: a named group of bodies, joints and devices such
// as a robot, a table or a door.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

class Simulation;
struct AssemblyAccess;  // implementation of these handles in the simulation

/// Handle of a motor. Copies refer to the same motor. A default-constructed handle and the handle
/// of a name that does not exist do nothing. Like all handles of this file, it must only be used by
/// its controller, in the calls of configure() and update().
class COGRSIM_API MotorHandle {
 public:
  MotorHandle() = default;

  /// Sets the target from the next step on. Its unit depends on the mode of the motor: speed
  /// [rad/s] or [m/s], torque [N m] or force [N], position or servo position [rad] or [m], voltage
  /// of a DC motor [V]. The target is clamped to the limits of the motor. A value that is not
  /// finite is reported as a fault of the controller, and the target stays unchanged.
  void set(double target);

  /// The current target, in the unit of the mode.
  double target() const;
  /// Mean effort during the last step [N m] or [N].
  double effort() const;
  MotorMode mode() const;
  /// The smaller of the limits of the motor and its joint: [rad/s] or [m/s], and [N m] or [N].
  double max_speed() const;
  double max_effort() const;
  /// Largest voltage of mode dc [V]; infinity: no limit.
  double max_voltage() const;
  /// Limits of the driven joint axis [rad] or [m]; -infinity and infinity: none.
  double lower() const;
  double upper() const;
  /// Dotted name of the driven joint; "" for a handle of no motor.
  const std::string& joint() const;
  /// Whether the handle refers to a motor.
  bool valid() const { return access_ != nullptr; }

 private:
  friend class Assembly;
  MotorHandle(AssemblyAccess* access, int motor) : access_(access), motor_(motor) {}
  AssemblyAccess* access_ = nullptr;
  int motor_ = -1;
};

/// Handle of an input: a number that a person or a program sets while the run goes (SetInput, the
/// studio's sliders). Copies refer to the same input.
class COGRSIM_API InputHandle {
 public:
  InputHandle() = default;
  /// The present value, within the limits of the input; 0 for a default-constructed handle.
  double value() const;

 private:
  friend class Assembly;
  InputHandle(AssemblyAccess* access, std::size_t input) : access_(access), input_(input) {}
  AssemblyAccess* access_ = nullptr;
  std::size_t input_ = 0;
};

/// Handle of a sensor with access to its latest reading. The typed handles (Encoder, PoseSensor,
/// Imu, …) derive from it.
class COGRSIM_API SensorHandle {
 public:
  SensorHandle() = default;

  /// False before the first reading, while the sensor is switched off, and if the reading dropped
  /// out.
  bool valid() const;
  /// Type of the sensor ("encoder"), or the name of its plugin; "" for a handle of no sensor.
  const std::string& type() const;
  /// Time of the measured frame [s].
  double time() const;
  /// Number of readings so far; it changes with every new reading.
  std::uint64_t sequence() const;
  /// Value of a channel by its index, in the unit of the channel; NaN if the reading is not valid.
  double value(int channel) const;
  /// The complete reading; empty before the first one. The reference is valid until the next step.
  const Reading& reading() const;
  /// Switches the sensor on or off.
  void enable(bool on);

 protected:
  /// Dotted name of the body with this index, "" for -1.
  std::string body_name(int body) const;
  bool bound() const { return access_ != nullptr; }
  /// Precondition: bound().
  const SensorModel& description() const;

 private:
  friend class Assembly;
  AssemblyAccess* access_ = nullptr;
  int sensor_ = -1;
};

/// Encoder: position and speed of a joint axis.
class Encoder : public SensorHandle {
 public:
  static constexpr const char* kType = "encoder";
  double position() const { return value(0); }  ///< [rad] or [m]
  double velocity() const { return value(1); }  ///< [rad/s] or [m/s]
};

/// Pose sensor: pose and twist of the sensor frame in the world, as an ideal tracking system
/// measures them.
class PoseSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "pose";
  /// Pose in the world; position in [m].
  Pose pose() const {
    return {{value(0), value(1), value(2)}, Quat(value(3), value(4), value(5), value(6))};
  }
  /// Twist of the origin of the sensor frame, in world axes [m/s], [rad/s].
  Twist twist() const {
    return {{value(7), value(8), value(9)}, {value(10), value(11), value(12)}};
  }
};

/// Inertial measurement unit; its values are in the axes of the sensor.
class Imu : public SensorHandle {
 public:
  static constexpr const char* kType = "imu";
  Vec3 specific_force() const { return {value(0), value(1), value(2)}; }    ///< [m/s^2]
  Vec3 angular_velocity() const { return {value(3), value(4), value(5)}; }  ///< [rad/s]
};

/// Infrared sensor: distance along the x axis of the sensor.
class COGRSIM_API Infrared : public SensorHandle {
 public:
  static constexpr const char* kType = "infrared";
  /// Distance [m]. +infinity: no surface within the range; -infinity: nearer than the minimum
  /// range; NaN: not valid.
  double distance() const { return value(0); }
  /// Dotted name of the detected body, "" if there is none.
  std::string body() const;
  /// Output voltage of the device that the scene selects [V]; NaN if it selects none.
  double volts() const { return value(2); }
};

/// Lidar: distances in many directions, from right to left in each ring, with the lowest ring
/// first.
class COGRSIM_API Lidar : public SensorHandle {
 public:
  static constexpr const char* kType = "lidar";
  std::size_t size() const;  ///< number of rays in all rings
  /// Distance of one ray [m], as Infrared::distance(). Precondition: ray < size().
  double range(std::size_t ray) const { return value(static_cast<int>(ray)); }
  /// All distances [m], (rings x rays) row-major; empty if not valid.
  std::vector<double> ranges() const;
  /// Unit direction of one ray in the sensor frame. Precondition: ray < size().
  Vec3 direction(std::size_t ray) const;

 private:
  mutable std::vector<Vec3> directions_;  // computed at the first use
};

/// Camera: its latest image.
class COGRSIM_API CameraSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "camera";
  /// The latest image, immutable and shared; nullptr if not valid.
  std::shared_ptr<const Picture> picture() const { return valid() ? reading().picture : nullptr; }
  double brightness() const { return value(0); }  ///< mean of all colour values, 0 to 1
  double nearest() const { return value(1); }     ///< smallest depth [m]; NaN without a depth image
};

/// Contact sensor.
class COGRSIM_API ContactSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "contact";
  bool touching() const { return value(0) > 0.0; }
  /// Total contact force on the body or assembly of the sensor, in the axes of the sensor [N].
  Vec3 force() const { return {value(2), value(3), value(4)}; }
  /// The contact points in the world frame; empty if not valid. The reference is valid until the
  /// next step.
  const std::vector<Contact>& points() const { return reading().contacts; }
  /// Dotted names of the touching bodies, each once.
  std::vector<std::string> bodies() const;
};

/// Force-torque sensor: the wrench that a joint transmits from its parent to its child, about the
/// joint origin, in the joint axes of the child.
class ForceTorque : public SensorHandle {
 public:
  static constexpr const char* kType = "force-torque";
  Vec3 force() const { return {value(0), value(1), value(2)}; }   ///< [N]
  Vec3 torque() const { return {value(3), value(4), value(5)}; }  ///< [N m]
};

/// The assembly of a controller, passed to configure(). Requesting an element that does not exist
/// does not throw. The error is collected together with the existing names, the returned handle
/// does nothing, and after configure() loading fails with all collected errors at once.
///
/// The object is destroyed after configure(). A controller that needs it later stores a copy, which
/// is cheap and refers to the same assembly. It must only be used in the calls of the controller.
class COGRSIM_API Assembly {
 public:
  /// Dotted name of the assembly.
  const std::string& name() const;

  /// A motor by its name inside the assembly ("left") or inside a nested assembly ("arm.elbow").
  MotorHandle motor(const std::string& name);
  /// The same, for a controller that needs this mode: a motor with another one is an error as by
  /// fail().
  MotorHandle motor(const std::string& name, MotorMode mode);
  /// A sensor by its name, as a typed handle: `robot.sensor<Infrared>("front")`.
  template <class Type>
  Type sensor(const std::string& name) {
    Type handle;
    bind(handle, name, Type::kType);
    return handle;
  }
  /// A sensor of any type; its values are accessed by channel index.
  SensorHandle any_sensor(const std::string& name);

  std::vector<std::string> motor_names() const;
  std::vector<std::string> sensor_names() const;

  /// Value of a parameter. Type is double, int, bool, std::string or std::vector<double>; the
  /// parameter must be declared with that type in the parameter table of the plugin.
  template <class Type>
  Type parameter(const std::string& name);

  /// Position [rad] or [m] and speed [rad/s] or [m/s] of the joint axis that a motor drives, at the
  /// end of the last step. They allow feedback control without an encoder in the scene.
  double joint_position(const MotorHandle& motor) const;
  double joint_velocity(const MotorHandle& motor) const;

  /// Seed of the run, and name of the backend that it is on.
  std::uint64_t seed() const;
  const std::string& backend() const;
  /// Parameters of the scene that were set when it was compiled (`--set`), as texts by name.
  const std::map<std::string, std::string>& set_parameters() const;

  /// Folder of the scene file, for data files; "" if a program created the scene.
  std::string scene_folder() const;
  /// The plan of a maze of the scene by its dotted name; "" selects the only maze. If it does not
  /// exist, the error is collected and the result is nullptr.
  const MazeModel* maze(const std::string& name);

  /// Declares an input of this controller, in configure(). Limits and value are finite, and the value
  /// within the limits; otherwise, and with more than 64 inputs or a name that is taken, loading fails.
  /// Inputs are part of snapshots.
  InputHandle input(const std::string& name, double value, double lower, double upper,
                    const std::string& unit = {});

  /// Sets the value of a declared output (see output() in cogrsim/plugin/descriptor.h). An
  /// undeclared output is a load error in configure() and a fault in update().
  void publish(const std::string& output, double value);
  /// A number drawn uniformly from [low, high), from the seeded random stream of the controller.
  double uniform(double low, double high);

  /// Creates a planner, steering method or learner by the name of its plugin, see
  /// cogrsim/algorithms/. `Type` is one of the interfaces there. If the plugin does not exist,
  /// belongs to another family or rejects a parameter, the error is collected and the result is
  /// nullptr.
  template <class Type>
  std::shared_ptr<Type> algorithm(const std::string& name, const Parameters& parameters = {}) {
    return std::static_pointer_cast<Type>(find_algorithm(name, Type::kFamily, parameters));
  }

  /// Reports a message to the user; the run continues.
  void report(const std::string& message);
  /// Reports an error of the scene; loading fails with it.
  void fail(const std::string& message);

  explicit Assembly(std::shared_ptr<AssemblyAccess> access) : access_(std::move(access)) {}
  AssemblyAccess& access() { return *access_; }

 private:
  void bind(SensorHandle& handle, const std::string& name, const char* type);
  const ParameterValue* find_parameter(const std::string& name, ParameterType type);
  std::shared_ptr<void> find_algorithm(const std::string& name, const char* family,
                                       const Parameters& parameters);
  std::shared_ptr<AssemblyAccess> access_;
};

template <>
COGRSIM_API double Assembly::parameter<double>(const std::string& name);
template <>
COGRSIM_API int Assembly::parameter<int>(const std::string& name);
template <>
COGRSIM_API bool Assembly::parameter<bool>(const std::string& name);
template <>
COGRSIM_API std::string Assembly::parameter<std::string>(const std::string& name);
template <>
COGRSIM_API std::vector<double> Assembly::parameter<std::vector<double>>(const std::string& name);

}  // namespace cogrsim
