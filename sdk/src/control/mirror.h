// What a controller in a process of its own sees of the simulation, and what it does there: written
// on one side, applied on the other.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/wire.h"
#include "simulation/impl.h"

namespace cogrsim {

struct Picture;

/// What is asked of the process.
enum class HostCall : std::uint8_t { configure, update, save, restore, end };

/// Motors and sensors that the controller of an assembly can come by, by index.
struct Devices {
  std::vector<int> motors, sensors;
  Devices() = default;
  Devices(const SceneModel& model, int assembly);
};

/// The simulation's side.
class MirrorWriter {
 public:
  explicit MirrorWriter(AssemblyAccess& access) : access_(access) {}
  /// The scene, if the process does not know it yet.
  void put_scene(WireWriter& out);
  /// What the controller sees at this moment.
  void put_state(WireWriter& out);
  /// Carries out what it did. False: it cannot be; nothing of it is done then.
  bool take_deeds(WireReader& in);

 private:
  AssemblyAccess& access_;
  Devices devices_;
  SceneModelPtr shown_;                                   // the model that the process knows
  std::vector<std::shared_ptr<const Picture>> pictures_;  // that it has, by sensor of devices_
};

/// The process's side: a Simulation::Impl without a world, filled in from outside.
class MirrorReader {
 public:
  explicit MirrorReader(Simulation::Impl& simulation) : simulation_(simulation) {}
  void take_scene(WireReader& in);
  void take_state(WireReader& in, AssemblyAccess& access);
  void put_deeds(WireWriter& out, AssemblyAccess& access);

 private:
  void take_reading(WireReader& in, std::size_t device);

  Simulation::Impl& simulation_;
  bool fresh_ = false;  // the scene has come since the last state
  Devices devices_;
  std::vector<std::shared_ptr<const Picture>> pictures_;  // last ones, by sensor of devices_
};

}  // namespace cogrsim
