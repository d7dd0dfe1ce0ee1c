// Where a two-wheel vehicle is, and which way it should turn to follow a list of waypoints.
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

/// Ideal rolling: left = (v - w b/2)/r, right = (v + w b/2)/r, with the wheels' radius r [m] and
/// their distance b [m].
WheelSpeeds wheel_speeds(const Velocity& velocity, double radius, double track);

/// The same wheel speeds, both scaled down by one factor until neither exceeds its limit [rad/s],
/// so that the vehicle slows down and keeps its curvature.
WheelSpeeds limited(const WheelSpeeds& speeds, double max_left, double max_right);

/// Moves `pose` by what the wheels rolled: `left` and `right` are arc lengths [m]. Exact for
/// constant wheel speeds (a circular arc).
PlanarPose rolled(const PlanarPose& pose, double left, double right, double track);

/// The same angle within (-pi, pi].
double wrapped(double angle);

struct FollowerSettings {
  double speed = 0.2;         ///< cruising [m/s], > 0
  double max_turn = 2.0;      ///< [rad/s], > 0
  double turn_gain = 4.0;     ///< turn rate per heading error [1/s], > 0
  double lookahead = 0.1;     ///< [m], > 0
  double arrival = 0.03;      ///< a waypoint counts as reached this near [m], > 0
  double acceleration = 1.0;  ///< brakes for the last waypoint with this [m/s^2], > 0
  bool loop = false;          ///< after the last waypoint comes the first
};

/// Drives along the straight lines between waypoints.
///
/// It aims at a point `lookahead` further along the line than its own projection. With the heading
/// error a towards that point it turns at clamp(turn_gain a, +-max_turn) and drives at
/// speed (1 - |a|/45 deg), not below 0: corners are turned on the spot, small errors on the move.
class PathFollower {
 public:
  PathFollower() = default;
  /// The first line starts where the vehicle is at the first update.
  PathFollower(std::vector<Point> waypoints, const FollowerSettings& settings);

  Velocity update(const PlanarPose& pose);
  /// Past the last waypoint; never with `loop`.
  bool done() const { return done_; }
  int next_waypoint() const { return static_cast<int>(next_); }

  /// How far it is, to go on from later.
  struct Progress {
    Point from;
    bool started = false, done = false;
    std::size_t next = 0;
  };
  Progress progress() const { return {from_, started_, done_, next_}; }
  /// False: it has fewer waypoints than that.
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
