// Transfer of state between the simulation and an isolated controller: the state that the
// controller reads, and the effects of the controller on the simulation. One side writes, the other
// applies.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "assembly/assembly_access.h"
#include "control/process/wire.h"

namespace cogrsim {

struct Picture;

/// The call that a request asks for.
enum class HostCall : std::uint8_t { configure, update, save, restore, end };

/// Indices of the motors and sensors to which the controller of an assembly has access.
struct DeviceIndices {
  std::vector<int> motors, sensors;
  DeviceIndices() = default;
  DeviceIndices(const SceneModel& model, int assembly);
};

/// The scene as text for controllers in processes of their own, without shapes, meshes, rules and
/// other elements that they do not need. Computed once for each model.
struct SceneForControllers {
  SceneModelPtr model, original;
  std::string text;
  const std::string& of(const SceneModelPtr& now, const SceneModelPtr& at_start);
};

/// The side of the simulation.
class ProxyWriter {
 public:
  /// `scene` is shared by the controllers of a run and must outlive this object.
  ProxyWriter(AssemblyAccess& access, SceneForControllers& scene)
      : access_(access), scene_(scene) {}
  /// Writes the scene if the process does not have it yet.
  void put_scene(WireWriter& out);
  /// Writes the current state of the devices.
  void put_state(WireWriter& out);
  /// Applies the effects of the controller. False: the data are inconsistent; nothing is applied.
  bool take_effects(WireReader& in);

 private:
  AssemblyAccess& access_;
  SceneForControllers& scene_;
  DeviceIndices devices_;
  SceneModelPtr shown_;                                   // the model that the process has
  std::vector<std::shared_ptr<const Picture>> pictures_;  // last sent, by sensor of devices_
};

/// The side of the controller process: a copy of the devices of the controller.
class RemoteDevices final : public DevicePort {
 public:
  explicit RemoteDevices(const std::vector<std::string>& plugin_folders)
      : loader_(plugin_folders) {}

  double time() const override { return 0.0; }
  const SceneModelPtr& model() const override { return model_; }
  const SceneModelPtr& original() const override { return original_; }
  PluginLoader& loader() override { return loader_; }
  double target(int motor) const override { return motors_[index(motor)].target; }
  void set_target(int motor, double target) override;
  double effort(int motor) override { return motors_[index(motor)].effort; }
  double joint_position(int motor) override { return motors_[index(motor)].position; }
  double joint_velocity(int motor) override { return motors_[index(motor)].velocity; }
  const Reading& reading(int sensor) const override { return readings_[index(sensor)]; }
  void enable(int sensor, bool on) override;
  void report(const std::string& source, const std::string& message) override;

  void take_scene(WireReader& in);
  void take_state(WireReader& in, AssemblyAccess& access);
  void put_effects(WireWriter& out, AssemblyAccess& access);

 private:
  struct MotorCopy {
    double target = 0.0, effort = 0.0, position = 0.0, velocity = 0.0;
    bool set = false;  ///< by the current call
  };

  static std::size_t index(int device) { return static_cast<std::size_t>(device); }
  void take_reading(WireReader& in, std::size_t device);

  PluginLoader loader_;
  SceneModelPtr model_, original_;
  std::vector<MotorCopy> motors_;
  std::vector<Reading> readings_;
  std::vector<bool> was_off_;                   // sensors, in the current call
  std::vector<std::string> sources_, reports_;  // messages of the current call
  std::size_t declared_ = 0;                    // inputs that the simulation knows
  bool fresh_ = false;                          // a scene was received after the last state
  DeviceIndices devices_;
  std::vector<std::shared_ptr<const Picture>> pictures_;  // last received, by sensor of devices_
};

}  // namespace cogrsim
