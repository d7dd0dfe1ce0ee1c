// The forces of the scene, computed for each step.
#pragma once

#include <vector>

#include "simulation/clock.h"
#include "simulation/element_signals.h"
#include "simulation/frame_source.h"
#include "simulation/world_host.h"

namespace cogrsim {

class ForceSystem {
 public:
  /// Computes the forces of the next step and gives them to the world. A factor that is not a finite
  /// number counts as 0. No cost in a scene without forces.
  void apply(WorldHost& host, const Clock& clock, const ChannelLookup& channels,
             FrameSource& frames);

 private:
  void add(const SceneModel& model, int body, const WorldState& state, const Vec3& force,
           const Vec3& point, const Vec3& torque);

  ElementSignals factors_;
  std::vector<Wrench> sums_;  // by body
  bool given_ = false;        // the world has forces
};

}  // namespace cogrsim
