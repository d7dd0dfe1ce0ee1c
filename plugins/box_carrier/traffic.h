// Two robots that see each other and do not talk: who gives way, and where the other may be.
#pragma once

#include <optional>

#include "sightings.h"

namespace box_carrier {

/// The other robot as its tower shows it: smoothed, with the speed at which it moves.
class Neighbour {
 public:
  /// A new sighting at a time [s].
  void see(const PlanarPoint& tower, double time);
  /// Empty: never seen.
  const std::optional<PlanarPoint>& place() const { return place_; }
  double vx() const { return vx_; }  ///< [m/s]
  double vy() const { return vy_; }

 private:
  std::optional<PlanarPoint> place_;
  double vx_ = 0.0, vy_ = 0.0, time_ = 0.0;
};

struct TrafficRules {
  bool gives_way = false;  ///< to the other, when both want the same room
  double caution = 0.45;   ///< kept by the one that gives way from an approaching other [m]
  double guard = 0.06;     ///< never nearer than the two discs and this [m]
};

/// Whether a robot at `pose`, of disc `radius`, may drive at `forward` [m/s] (negative: backwards)
/// with the other, of disc `other_radius`, where it is. Turning on the spot is always allowed: the
/// disc holds all of the robot.
bool may_drive(const PlanarPose& pose, double forward, double radius, const Neighbour& other,
               double other_radius, const TrafficRules& rules);

}  // namespace box_carrier
