// Odometry of a two-wheel vehicle, and following of a list of waypoints.
#pragma once

#include <vector>

#include "cogrsim/algorithms/steering.h"

namespace diff_drive {

using cogrsim::PlanarPose;
using Point = cogrsim::PlanarPoint;
using Velocity = cogrsim::PlanarVelocity;

/// Speeds of the two wheels [rad/s].
struct WheelSpeeds {
  double left = 0.0, right = 0.0;
};

/// Wheel speeds for ideal rolling: left = (v - w b/2)/r, right = (v + w b/2)/r, with the radius r
/// [m] of the wheels and their distance b [m].
WheelSpeeds wheel_speeds(const Velocity& velocity, double radius, double track);

/// Scales both wheel speeds by one factor so that neither exceeds its limit [rad/s]: the vehicle
/// slows down and the curvature stays the same.
WheelSpeeds limited(const WheelSpeeds& speeds, double max_left, double max_right);

/// Odometry: moves `pose` by the arc lengths `left` and `right` of the wheels [m]. Exact for
/// constant wheel speeds (a circular arc).
PlanarPose rolled(const PlanarPose& pose, double left, double right, double track);

struct FollowerSettings {
  double speed = 0.2;         ///< cruising [m/s], > 0
  double max_turn = 2.0;      ///< [rad/s], > 0
  double turn_gain = 4.0;     ///< turn rate per heading error [1/s], > 0
  double lookahead = 0.1;     ///< [m], > 0
  double arrival = 0.03;      ///< distance at which a waypoint is reached [m], > 0
  double acceleration = 1.0;  ///< deceleration before the last waypoint [m/s^2], > 0
  bool loop = false;          ///< continue with the first waypoint after the last
};

/// Follows the straight lines between waypoints.
///
/// The target is the point `lookahead` beyond the projection of the vehicle on the line. With the
/// heading error a towards the target, the turn rate is clamp(turn_gain a, +-max_turn) and the
/// speed is speed (1 - |a|/45 deg), at least 0: the vehicle turns on the spot at corners and
/// corrects small errors while driving.
class PathFollower {
 public:
  PathFollower() = default;
  /// The first line starts at the position of the vehicle at the first update.
  PathFollower(std::vector<Point> waypoints, const FollowerSettings& settings);

  Velocity update(const PlanarPose& pose);
  /// Whether the last waypoint was reached; never with `loop`.
  bool done() const { return done_; }
  int next_waypoint() const { return static_cast<int>(next_); }

  /// The progress, for restoring it later.
  struct Progress {
    Point from;
    bool started = false, done = false;
    std::size_t next = 0;
  };
  Progress progress() const { return {from_, started_, done_, next_}; }
  /// Restores the progress; false: there are fewer waypoints.
  bool resume(const Progress& progress) {
    if (progress.next > waypoints_.size() ||
        (!progress.done && progress.next == waypoints_.size() && !waypoints_.empty())) {
      return false;
    }
    from_ = progress.from;
    started_ = progress.started;
    done_ = progress.done;
    next_ = progress.next;
    return true;
  }

 private:
  void advance();

  std::vector<Point> waypoints_;
  FollowerSettings settings_;
  Point from_;
  bool started_ = false;
  bool done_ = false;
  std::size_t next_ = 0;
};

}  // namespace diff_drive
