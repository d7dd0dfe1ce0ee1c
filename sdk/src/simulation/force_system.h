// The forces of the scene, computed for each step.
#pragma once

#include <vector>

#include "cogrsim/control/command.h"
#include "geometry/displaced_volume.h"
#include "simulation/clock.h"
#include "simulation/element_signals.h"
#include "simulation/frame_source.h"
#include "simulation/world_host.h"

namespace cogrsim {

class ForceSystem {
 public:
  /// A force of a command. Part of snapshots.
  struct Applied {
    int body = kWorld;
    ApplyForce command;
    double until = 0.0;  ///< [s]
  };

  /// Adds the force of a command to those of the following steps.
  Result<> apply(const ApplyForce& command, WorldHost& host, const Clock& clock);
  const std::vector<Applied>& applied() const { return applied_; }
  void set_applied(std::vector<Applied> applied) { applied_ = std::move(applied); }

  /// Computes the forces of the next step and gives them to the world. A factor that is not a finite
  /// number counts as 0. No cost without forces.
  void apply(WorldHost& host, const Clock& clock, const ChannelLookup& channels,
             FrameSource& frames);

 private:
  // Of a body's origin.
  struct Motion {
    Pose X_WB;
    Twist V_WB;
  };
  Motion motion_of(const SceneModel& model, int body, double ahead) const;
  void buoyancy(const SceneModelPtr& model, std::size_t force, double ahead);
  void add(const SceneModel& model, int body, const Pose& X_WB, const Vec3& force,
           const Vec3& point, const Vec3& torque);

  ElementSignals factors_;
  SceneModelPtr displaced_of_;                                    // the model of `displaced_`
  std::vector<std::vector<geometry::DisplacedShape>> displaced_;  // by force
  std::vector<Applied> applied_;
  std::vector<Wrench> sums_;  // by body
  // By body: now, or, with `is_ahead_`, when forces are evaluated.
  std::vector<Pose> poses_;
  std::vector<Twist> twists_;
  bool is_ahead_ = false;
  bool given_ = false;  // the world has forces
};

}  // namespace cogrsim
