// A running world: converts between the scene of CogRSim and the engine in flight.h.
#pragma once

#include <vector>

#include <cogrsim/physics/world.h>

#include "flight.h"

namespace adapter {

/// Checks that the engine can build this scene. Errors name the element and its source location.
cogrsim::Result<> check_scene(const cogrsim::SceneModel& model);

class FlightWorld final : public cogrsim::World, public cogrsim::KinematicDrive {
 public:
  /// Precondition: check_scene(*model). Every step consists of `substeps` >= 1 equal parts.
  FlightWorld(cogrsim::SceneModelPtr model, int substeps);

  const cogrsim::SceneModelPtr& model() const override { return now_.model; }
  double time() const override { return now_.time; }
  cogrsim::StepResult step(double dt, const std::vector<cogrsim::Drive>& drives) override;
  void get_state(cogrsim::WorldState& out) const override;
  cogrsim::Result<> set_state(const cogrsim::WorldState& state) override;
  void get_contacts(std::vector<cogrsim::Contact>& out) const override;
  cogrsim::Result<> add(const cogrsim::SceneModelPtr& next) override;
  cogrsim::Result<> remove(const cogrsim::SceneModelPtr& next) override;
  cogrsim::Result<> change(const cogrsim::SceneModelPtr& next) override;
  cogrsim::SnapshotPtr save() const override;
  cogrsim::Result<> restore(const cogrsim::SnapshotPtr& snapshot) override;
  cogrsim::Result<> reset() override;
  void* extension(std::string_view id) override;

  cogrsim::Result<> set_kinematic_twist(int body, const cogrsim::Twist& twist) override;

 private:
  // The complete state; a snapshot is a copy of it.
  struct Everything {
    cogrsim::SceneModelPtr model;
    double time = 0.0;
    std::vector<flight::Body> bodies;  // one per entry of SceneModel::bodies
  };
  struct Snapshot;

  cogrsim::SceneModelPtr first_;  // the initial scene
  int substeps_;
  Everything now_;
  std::vector<flight::Body> trial_;  // reused, so that a step allocates no memory
};

}  // namespace adapter
