// A robot, a table, a door: a named group of bodies, joints and devices, as its controller sees it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

class Simulation;
struct AssemblyAccess;  // the simulation's side of these handles

/// Handle of a motor. Copies refer to the same motor; a default-constructed one, or one that was
/// asked for under a name that is not there, does nothing.
class COGRSIM_API MotorHandle {
 public:
  MotorHandle() = default;

  /// What the motor aims at from the coming step on, in the unit of its mode: speed [rad/s, m/s],
  /// torque or force, position, servo position, voltage of a DC motor [V]. Beyond the motor's
  /// limits it is clamped. A value that is not finite is a fault of the controller: it is reported,
  /// and the target stays as it was.
  void set(double target);

  double target() const;
  /// Mean effort of the last step [N m] or [N].
  double effort() const;
  MotorMode mode() const;
  /// Limit of the motor and its joint together.
  double max_speed() const;
  double max_effort() const;
  bool valid() const { return access_ != nullptr; }

 private:
  friend class Assembly;
  MotorHandle(AssemblyAccess* access, int motor) : access_(access), motor_(motor) {}
  AssemblyAccess* access_ = nullptr;
  int motor_ = -1;
};

/// Handle of a sensor: its latest reading. Typed views (Encoder, PoseSensor, Imu, …) derive from
/// it.
class COGRSIM_API SensorHandle {
 public:
  SensorHandle() = default;

  /// False before the first reading, while switched off, and when the reading dropped out.
  bool valid() const;
  /// Time of the frame that was read [s].
  double time() const;
  /// Readings so far: tells a new one from an old one.
  std::uint64_t sequence() const;
  /// Value of a channel by index, NaN when not valid.
  double value(int channel) const;
  /// All of it; an empty one before the first reading. Valid until the next step.
  const Reading& reading() const;
  void enable(bool on);

 protected:
  /// Dotted name of a body of the scene, "" for -1.
  std::string body_name(int body) const;
  bool bound() const { return access_ != nullptr; }
  /// Precondition: bound().
  const SensorModel& description() const;

 private:
  friend class Assembly;
  AssemblyAccess* access_ = nullptr;
  int sensor_ = -1;
};

/// Joint position and speed.
class Encoder : public SensorHandle {
 public:
  static constexpr const char* kType = "encoder";
  double position() const { return value(0); }  ///< [rad] or [m]
  double velocity() const { return value(1); }  ///< [rad/s] or [m/s]
};

/// Where the sensor is in the world, as a tracking system would tell.
class PoseSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "pose";
  Pose pose() const {
    return {{value(0), value(1), value(2)}, Quat(value(3), value(4), value(5), value(6))};
  }
  Twist twist() const {
    return {{value(7), value(8), value(9)}, {value(10), value(11), value(12)}};
  }
};

/// Inertial measurement unit, in its own axes.
class Imu : public SensorHandle {
 public:
  static constexpr const char* kType = "imu";
  Vec3 specific_force() const { return {value(0), value(1), value(2)}; }    ///< [m/s^2]
  Vec3 angular_velocity() const { return {value(3), value(4), value(5)}; }  ///< [rad/s]
};

/// Distance along the sensor's x axis.
class COGRSIM_API Infrared : public SensorHandle {
 public:
  static constexpr const char* kType = "infrared";
  /// [m]; +infinity: nothing within the range, -infinity: nearer than it begins, NaN: not valid.
  double distance() const { return value(0); }
  /// Dotted name of the body that is seen, "" when there is none.
  std::string body() const;
  /// Of the device named in the scene [V]; NaN when none is.
  double volts() const { return value(2); }
};

/// Distances in many directions, from right to left, ring by ring from the lowest.
class COGRSIM_API Lidar : public SensorHandle {
 public:
  static constexpr const char* kType = "lidar";
  std::size_t size() const;  ///< rays of a reading, all rings together
  /// [m], as Infrared::distance(). Precondition: ray < size().
  double range(std::size_t ray) const { return value(static_cast<int>(ray)); }
  /// All of them, (rings x rays); empty when not valid.
  std::vector<double> ranges() const;
  /// Where ray `ray` points, unit, in the sensor's frame.
  Vec3 direction(std::size_t ray) const;

 private:
  mutable std::vector<Vec3> directions_;  // made when first asked for
};

/// What a camera saw.
class COGRSIM_API CameraSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "camera";
  /// nullptr when not valid. May be kept as long as one likes.
  std::shared_ptr<const Picture> picture() const { return valid() ? reading().picture : nullptr; }
  double brightness() const { return value(0); }  ///< mean of all colour values, 0 to 1
  double nearest() const { return value(1); }     ///< smallest depth [m]; NaN without depth
};

/// Touch.
class COGRSIM_API ContactSensor : public SensorHandle {
 public:
  static constexpr const char* kType = "contact";
  bool touching() const { return value(0) > 0.0; }
  /// Sum of the forces on what is felt, in the sensor's axes [N].
  Vec3 force() const { return {value(2), value(3), value(4)}; }
  /// The points, in the world; empty when not valid. Until the next step.
  const std::vector<Contact>& points() const { return reading().contacts; }
  /// Dotted names of what touches, each once.
  std::vector<std::string> bodies() const;
};

/// What a joint transmits from its parent to its child, about the joint, in the child's joint axes.
class ForceTorque : public SensorHandle {
 public:
  static constexpr const char* kType = "force-torque";
  Vec3 force() const { return {value(0), value(1), value(2)}; }   ///< [N]
  Vec3 torque() const { return {value(3), value(4), value(5)}; }  ///< [N m]
};

/// What a controller is given in configure(). Asking for something that is not there does not
/// throw: it is noted, with what is there, and makes the load fail after configure() with all such
/// mistakes at once; the handle then returned does nothing.
///
/// The object itself is gone after configure(); a controller that needs it later keeps a copy,
/// which is cheap and refers to the same assembly.
class COGRSIM_API Assembly {
 public:
  /// Dotted name of the assembly.
  const std::string& name() const;

  /// Devices by their name inside the assembly ("left"), or of an assembly in it ("arm.elbow").
  MotorHandle motor(const std::string& name);
  template <class Type>
  Type sensor(const std::string& name) {
    Type handle;
    bind(handle, name, Type::kType);
    return handle;
  }
  /// A sensor of any type, by channel index.
  SensorHandle any_sensor(const std::string& name);

  std::vector<std::string> motor_names() const;
  std::vector<std::string> sensor_names() const;

  /// Type is double, int, bool, std::string or std::vector<double>; the name must be declared in
  /// the plugin's parameter table, with that type.
  template <class Type>
  Type parameter(const std::string& name);

  /// Position and spin of the joint a motor drives, at the end of the last step: for controllers
  /// that close a loop on a joint without wanting an encoder in the scene.
  double joint_position(const MotorHandle& motor) const;
  double joint_velocity(const MotorHandle& motor) const;

  /// Folder of the scene file, "" for a scene made by a program: where data files are looked for.
  std::string scene_folder() const;
  /// The plan of a maze of the scene by its dotted name, "" for the only one. nullptr: not there;
  /// noted, as above.
  const MazeModel* maze(const std::string& name);

  /// Value of a declared output (see output() in cogrsim/plugin/descriptor.h) from now on. One that
  /// is not declared is a mistake in configure(), a fault in update().
  void publish(const std::string& output, double value);
  /// Uniform in [low, high) from the controller's own seeded stream.
  double uniform(double low, double high);

  /// A planner, steering or learner by the name of its plugin: see cogrsim/algorithms/. nullptr: not
  /// there, of another family, or a parameter is wrong; noted, as above. `Type` is one of the
  /// interfaces in cogrsim/algorithms/.
  template <class Type>
  std::shared_ptr<Type> algorithm(const std::string& name, const Parameters& parameters = {}) {
    return std::static_pointer_cast<Type>(find_algorithm(name, Type::kFamily, parameters));
  }

  /// Notes something to tell the user that does not stop the run.
  void report(const std::string& message);
  /// Notes a mistake of the scene: the load fails with it.
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
