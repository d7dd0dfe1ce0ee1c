// The forces of the scene, computed for each step.
#pragma once

#include <functional>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/physics/world.h"
#include "cogrsim/signals/signal.h"

namespace cogrsim {

class ForceSystem {
 public:
  /// Computes the forces of a step of length `dt` [s] that starts at `time` [s] in `state`, and gives
  /// them to the world. `frame` returns a frame with the contents and the latest outputs of
  /// controllers; it is called only if a factor needs it. A factor that is not a finite number counts
  /// as 0. No cost in a scene without forces.
  void apply(World& world, const SceneModelPtr& model, const WorldState& state, double time,
             double dt, const ChannelLookup& channels,
             const std::function<FramePtr(const FrameContents&)>& frame);

 private:
  void resolve(const SceneModelPtr& model, const ChannelLookup& channels);
  void add(const SceneModel& model, int body, const WorldState& state, const Vec3& force,
           const Vec3& point, const Vec3& torque);

  SceneModelPtr model_;                  // that `factors_` belong to
  std::vector<Signal> factors_;          // by force
  std::vector<Wrench> sums_;             // by body
  bool given_ = false;                   // the world has forces
};

}  // namespace cogrsim
