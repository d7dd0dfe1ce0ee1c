// The four primitive actions of a robot in a maze of square cells, realised by its two wheels.
#pragma once

#include "cogrsim/algorithms/grid.h"

namespace grid_navigator {

/// Place and heading in the maze's frame: x to the east, y to the north, the heading from x to y.
struct PlanarPose {
  double x = 0.0, y = 0.0;  ///< [m]
  double heading = 0.0;     ///< [rad]
};

using Cell = cogrsim::Cell;
/// North, south, east and west of the maze's frame.
using Action = cogrsim::Side;
inline constexpr Action kActions[] = {Action::north, Action::south, Action::east, Action::west};

/// The cell an action leads to; it may be outside of the maze.
Cell neighbour(const Cell& cell, Action action);
/// [rad]: north is pi/2, east 0.
double heading_of(Action action);
/// The same angle within (-pi, pi].
double wrapped(double angle);

/// Speed along the heading [m/s] and turn rate, left positive [rad/s].
struct Velocity {
  double forward = 0.0, turn = 0.0;
};

/// Dead reckoning by the wheels, drawn towards what the tracking system says.
///
/// Between two readings the pose follows the wheels (a circular arc); a reading moves it by `trust`
/// of the difference, so that noise of s [m] leaves about s sqrt(trust / 2) and a slip is forgotten
/// after 1/trust readings.
class Localiser {
 public:
  Localiser() = default;
  explicit Localiser(double trust) : trust_(trust) {}
  /// `left`, `right`: rolled since the last call [m]; `track`: between the wheels [m].
  void roll(double left, double right, double track);
  void correct(const PlanarPose& measured);
  const PlanarPose& pose() const { return pose_; }

 private:
  PlanarPose pose_;
  double trust_ = 0.2;
  bool started_ = false;
};

struct DriverSettings {
  double cell = 0.5;                ///< from centre to centre [m]
  double acceleration = 2.0;        ///< [m/s^2]
  double turn_rate = 6.0;           ///< [rad/s]
  double turn_acceleration = 30.0;  ///< [rad/s^2]
  double arrival = 0.01;            ///< a centre counts as reached this near [m]
  double clearance = 0.15;          ///< from its centre to what is seen ahead, at the target [m]
  double patience = 1.0;            ///< pushed in vain so long, an action ends blocked [s]
};

/// Executes one action after the other. An action turns the robot towards the neighbouring cell and
/// drives it to that cell's centre. What stands in the way ends it blocked: the robot is then back at
/// the centre of the cell it came from. A further action in the same direction may be given before
/// the end, and then it flows on without stopping.
class WheelDriver {
 public:
  enum class State { idle, turning, driving, returning };

  WheelDriver() = default;
  explicit WheelDriver(const DriverSettings& settings) : settings_(settings) {}

  /// The robot is in this cell. Unless it is in its middle already, it goes there first.
  void place(const Cell& cell, const PlanarPose& pose);

  /// Precondition: idle().
  void begin(Action action);
  /// Goes on to the next cell in the same direction. Precondition: may_extend().
  void extend();
  /// The action cannot be finished: brakes and goes back. Does nothing when idle or going back.
  void give_up();

  /// Ends a turn before it is done: nothing was tried. Precondition: state() is turning.
  void break_off() {
    state_ = State::idle;
    to_ = from_;
  }

  /// One control period. `ahead`: free distance in front of the robot's centre [m], infinite when
  /// nothing is seen; `speed`: cruising [m/s].
  Velocity update(const PlanarPose& pose, double ahead, double speed, double period);

  State state() const { return state_; }
  bool idle() const { return state_ == State::idle; }
  Action action() const { return action_; }
  /// Where the action began, or the last centre passed; when idle, where the robot is.
  const Cell& from() const { return from_; }
  /// Where it leads; when idle, where the robot is.
  const Cell& target() const { return to_; }
  /// So near to the target that it brakes unless told to go on.
  bool may_extend(const PlanarPose& pose) const;
  /// The last action that ended did so blocked.
  bool blocked() const { return blocked_; }
  /// Actions that ended so far, either way.
  int finished() const { return finished_; }

 private:
  struct Track {
    double along = 0.0;  ///< still to go [m]
    double aside = 0.0;  ///< to the left of the line [m]
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
  Velocity now_;  // what was commanded last
  double best_along_ = 0.0, waited_ = 0.0;
  double going_back_ = 0.0;  // [s]
  bool blocked_ = false;
  int finished_ = 0;
};

}  // namespace grid_navigator
