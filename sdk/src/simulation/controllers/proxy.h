// Transfer of state between the simulation and an isolated controller: the state that the
// controller reads, and the effects of the controller on the simulation. One side writes, the other
// applies.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/process/wire.h"
#include "simulation/impl.h"

namespace cogrsim {

struct Picture;

/// The call that a request asks for.
enum class HostCall : std::uint8_t { configure, update, save, restore, end };

/// Indices of the motors and sensors to which the controller of an assembly has access.
struct Devices {
  std::vector<int> motors, sensors;
  Devices() = default;
  Devices(const SceneModel& model, int assembly);
};

/// The side of the simulation.
class ProxyWriter {
 public:
  explicit ProxyWriter(AssemblyAccess& access) : access_(access) {}
  /// Writes the scene if the process does not have it yet.
  void put_scene(WireWriter& out);
  /// Writes the current state of the devices.
  void put_state(WireWriter& out);
  /// Applies the effects of the controller. False: the data are inconsistent; nothing is applied.
  bool take_effects(WireReader& in);

 private:
  AssemblyAccess& access_;
  Devices devices_;
  SceneModelPtr shown_;                                   // the model that the process has
  std::vector<std::shared_ptr<const Picture>> pictures_;  // last sent, by sensor of devices_
};

/// The side of the controller process: a Simulation::Impl without a world that receives its
/// contents from the simulation.
class ProxyReader {
 public:
  explicit ProxyReader(Simulation::Impl& simulation) : simulation_(simulation) {}
  void take_scene(WireReader& in);
  void take_state(WireReader& in, AssemblyAccess& access);
  void put_effects(WireWriter& out, AssemblyAccess& access);

 private:
  void take_reading(WireReader& in, std::size_t device);

  Simulation::Impl& simulation_;
  bool fresh_ = false;  // a scene was received after the last state
  Devices devices_;
  std::vector<std::shared_ptr<const Picture>> pictures_;  // last received, by sensor of devices_
};

}  // namespace cogrsim
