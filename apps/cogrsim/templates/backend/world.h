// A running world: converts between the scene of CogRSim and the engine in flight.h.
#pragma once

#include <vector>

#include <cogrsim/physics/hosted_world.h>

#include "flight.h"

namespace adapter {

/// Checks that the engine can build this scene. Errors name the element and its source location.
cogrsim::Result<> check_scene(const cogrsim::SceneModel& model);

// HostedWorld owns what is the same for all engines: the clock, snapshots, held reports, the order of
// a change, checks. What remains is building, stepping, reading and writing.
class FlightWorld final : public cogrsim::HostedWorld {
 public:
  /// Precondition: check_scene(*model). Every step consists of `substeps` >= 1 equal parts.
  FlightWorld(const cogrsim::SceneModelPtr& model, int substeps);

 private:
  struct Memory;  // what a snapshot holds

  const char* engine_name() const override { return "@NAME@"; }
  cogrsim::Result<> check(const cogrsim::SceneModel& model) const override {
    return check_scene(model);
  }
  cogrsim::Result<> build(const cogrsim::SceneModelPtr& model,
                          const cogrsim::WorldState& begin) override;
  cogrsim::Result<> rebuild(const cogrsim::SceneModelPtr& next, const cogrsim::WorldState& begin,
                            const cogrsim::SceneChange& change) override;
  cogrsim::StepResult advance(double dt, const std::vector<cogrsim::Drive>& drives,
                              const std::vector<double>& efforts) override;
  cogrsim::Pose pose(int body) const override;
  cogrsim::Twist twist(int body) const override;
  cogrsim::Result<> write(const cogrsim::WorldState& state) override;
  // There are no joints, and nothing touches.
  void read_efforts(std::vector<double>&, std::vector<double>&) const override {}
  void read_contacts(std::vector<cogrsim::Contact>&) const override {}
  void read_reactions(std::vector<cogrsim::Wrench>&) const override {}
  MemoryPtr save_memory() const override;
  cogrsim::Result<> restore_memory(const cogrsim::SceneModelPtr& model, const MemoryPtr& memory,
                                   const cogrsim::WorldState& begin) override;
  void move_kinematic(int body) override;
  // Of what HostedWorld could offer, this engine has the motion of kinematic bodies only.
  void* extension(std::string_view id) override {
    return id == KinematicDrive::kId ? static_cast<KinematicDrive*>(this) : nullptr;
  }

  /// From a body's origin to the point that the engine moves, in world axes.
  cogrsim::Vec3 arm(int body) const;

  int substeps_;
  std::vector<flight::Body> bodies_;  // one per entry of SceneModel::bodies
  std::vector<flight::Body> trial_;   // reused, so that a step allocates no memory
};

}  // namespace adapter
