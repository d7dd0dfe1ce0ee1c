// The shortest possible path of a run in a maze in hindsight, and checks of obstacle positions.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/algorithms/grid.h"

namespace maze_referee {

using cogrsim::Cell;

/// A cube that blocks its cell from a given time on.
struct Cube {
  Cell cell;
  double since = 0.0;  ///< [s]
};

/// Start, trigger, goal.
struct Task {
  Cell start, trigger, goal;
};

/// The best possible times of a robot.
struct Pace {
  double step = 1.0;     ///< time from the centre of a cell to the next, at full speed [s]
  double quarter = 0.0;  ///< additional time of a turn to the left or right [s]
  double half = 0.0;     ///< additional time of a reversal [s]
  /// Initial heading; a turn at the start costs as any other. Empty: any heading.
  std::optional<cogrsim::Side> heading;
};

/// The smallest number of steps from cell to cell with which a robot with complete knowledge could
/// have driven from the start through the trigger to the goal.
///
/// The doors are open as soon as the trigger is reached, and a cell can be entered until its cube
/// appears. The search proceeds in steps. With T_k(s) the earliest time at which k steps can lead
/// to s = (cell, heading, errand),
///
///     T_k+1(s') = min over s of T_k(s) + turn(s, s') + step,  if before the cube in the cell of
///     s'.
///
/// Cubes never disappear, so waiting has no advantage, and of two paths of equal length the earlier
/// one is never worse. Therefore the first k with a finite T_k at the goal is exact: no robot that
/// moves from centre to centre at this pace or slower needs fewer steps. nullopt: there is no path.
std::optional<int> fewest_steps(const cogrsim::MazeModel& maze, const Task& task,
                                const std::vector<Cube>& cubes, const Pace& pace);

/// Whether a robot in cell `at` can still complete its task with these cells blocked: reach the
/// trigger with closed doors, unless it has been there, and then the goal with open doors.
bool can_be_done(const cogrsim::MazeModel& maze, const Task& task, const Cell& at, bool triggered,
                 const std::vector<Cube>& cubes);

}  // namespace maze_referee
