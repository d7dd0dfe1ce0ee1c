// Coordination of two robots that see each other but do not communicate: right of way and
// clearance.
#pragma once

#include <optional>

#include "sightings.h"

namespace box_carrier {

/// Filtered position and velocity of the other robot, estimated from its tower.
class Neighbour {
 public:
  /// Processes a sighting at a time [s].
  void see(const PlanarPoint& tower, double time);
  /// The filtered position; nullopt: never seen.
  const std::optional<PlanarPoint>& position() const { return position_; }
  double vx() const { return vx_; }  ///< [m/s]
  double vy() const { return vy_; }

 private:
  std::optional<PlanarPoint> position_;
  double vx_ = 0.0, vy_ = 0.0, time_ = 0.0;
};

struct TrafficRules {
  bool gives_way = false;  ///< gives way to the other robot
  double caution = 0.45;   ///< distance that a robot giving way keeps from an approaching one [m]
  double margin = 0.06;    ///< smallest distance between the two discs [m]
};

/// Whether a robot at `pose` with a disc of `radius` may drive at `forward` [m/s] (negative:
/// backwards) while the other robot has a disc of `other_radius`. Turning on the spot is always
/// allowed, because the disc encloses the whole robot.
bool may_drive(const PlanarPose& pose, double forward, double radius, const Neighbour& other,
               double other_radius, const TrafficRules& rules);

}  // namespace box_carrier
