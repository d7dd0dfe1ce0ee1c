// The four primitive actions of a robot in a maze of square cells, realised by its two wheels.
#pragma once

#include "cogrsim/algorithms/grid.h"

namespace grid_navigator {

/// Position and heading in the maze frame: x to the east, y to the north, the heading from x to y.
struct PlanarPose {
  double x = 0.0, y = 0.0;  ///< [m]
  double heading = 0.0;     ///< [rad]
};

using Cell = cogrsim::Cell;
/// North, south, east and west in the maze frame.
using Action = cogrsim::Side;
inline constexpr Action kActions[] = {Action::north, Action::south, Action::east, Action::west};

/// The target cell of an action; it may be outside of the maze.
Cell neighbour(const Cell& cell, Action action);
/// Heading of an action [rad]: north is pi/2, east 0.
double heading_of(Action action);

/// Speed along the heading [m/s] and turn rate, left positive [rad/s].
struct Velocity {
  double forward = 0.0, turn = 0.0;
};

/// Pose estimate by wheel odometry and corrections from the tracking system.
///
/// Between two readings the pose follows the wheels (a circular arc). A reading moves it by the
/// fraction `trust` of the difference, so that noise with the standard deviation s [m] causes an
/// error of about s sqrt(trust / 2), and an error by slip decays over 1/trust readings.
class Localiser {
 public:
  Localiser() = default;
  explicit Localiser(double trust) : trust_(trust) {}
  /// `left`, `right`: rolled distances since the last call [m]; `track`: distance of the wheels
  /// [m].
  void roll(double left, double right, double track);
  void correct(const PlanarPose& measured);
  const PlanarPose& pose() const { return pose_; }

 private:
  PlanarPose pose_;
  double trust_ = 0.2;
  bool started_ = false;
};

struct DriverSettings {
  double cell = 0.5;                ///< distance between the centres of neighbouring cells [m]
  double acceleration = 2.0;        ///< [m/s^2]
  double turn_rate = 6.0;           ///< [rad/s]
  double turn_acceleration = 30.0;  ///< [rad/s^2]
  double arrival = 0.01;            ///< distance at which a centre is reached [m]
  double clearance = 0.15;          ///< to an obstacle ahead, at the target [m]
  double patience = 1.0;            ///< time without progress that ends an action [s]
};

/// Executes one action after the other. An action turns the robot towards the neighbouring cell and
/// drives it to the centre of that cell. If an obstacle is in the way, the action ends blocked, and
/// the robot is back at the centre of its previous cell. If the next action has the same direction
/// and is given before the end, the robot continues without stopping.
class WheelDriver {
 public:
  enum class State { idle, turning, driving, returning };

  WheelDriver() = default;
  explicit WheelDriver(const DriverSettings& settings) : settings_(settings) {}

  /// Sets the cell of the robot. The robot first drives to its centre if necessary.
  void start_in(const Cell& cell, const PlanarPose& pose);

  /// Starts an action. Precondition: idle().
  void begin(Action action);
  /// Continues to the next cell in the same direction. Precondition: may_extend().
  void extend();
  /// Aborts the action: brakes and returns. No effect when idle or already returning.
  void give_up();

  /// Cancels a turn; the action then does not count. Precondition: state() is turning.
  void break_off() {
    state_ = State::idle;
    to_ = from_;
  }

  /// Computes one control period. `ahead`: free distance in front of the robot's centre [m],
  /// infinite without an obstacle; `speed`: cruising speed [m/s].
  Velocity update(const PlanarPose& pose, double ahead, double speed, double period);

  State state() const { return state_; }
  bool idle() const { return state_ == State::idle; }
  Action action() const { return action_; }
  /// The start cell of the action or the last passed cell; when idle, the cell of the robot.
  const Cell& from() const { return from_; }
  /// The target cell of the action; when idle, the cell of the robot.
  const Cell& target() const { return to_; }
  /// Whether the robot is so close to the target that it brakes unless the action is extended.
  bool may_extend(const PlanarPose& pose) const;
  /// Whether the last action ended blocked.
  bool blocked() const { return blocked_; }
  /// Number of ended actions.
  int finished() const { return finished_; }

 private:
  struct Track {
    double along = 0.0;  ///< remaining distance [m]
    double aside = 0.0;  ///< offset to the left of the line [m]
  };
  Track track_to(const Cell& cell, const PlanarPose& pose) const;
  Velocity turn(const PlanarPose& pose);
  Velocity drive(const PlanarPose& pose, double ahead, double speed, double period);
  Velocity go_back(const PlanarPose& pose, double speed, double period);
  double steer(const PlanarPose& pose, double aside, bool backwards) const;
  bool pushed_in_vain(double along, double wanted, double period);
  void finish(bool blocked);

  DriverSettings settings_;
  State state_ = State::idle;
  Action action_ = Action::north;
  Cell from_, to_;
  Velocity now_;  // the last commanded velocity
  double best_along_ = 0.0, waited_ = 0.0;
  double going_back_ = 0.0;  // [s]
  bool blocked_ = false;
  int finished_ = 0;
};

}  // namespace grid_navigator
