// What can be said of a run in a maze when it is over, and of an obstacle before it is placed.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/algorithms/grid.h"

namespace maze_referee {

using cogrsim::Cell;

/// A cube blocks its cell from a time on.
struct Cube {
  Cell cell;
  double since = 0.0;  ///< [s]
};

/// Start, trigger, goal.
struct Task {
  Cell start, trigger, goal;
};

/// How fast a robot can be, at best.
struct Pace {
  double step = 1.0;     ///< from one cell's middle to the next, at full speed [s]
  double quarter = 0.0;  ///< what a turn to the left or right costs beside [s]
  double half = 0.0;     ///< and turning back [s]
  /// Where it looks at the start; a turn there costs as any other. Empty: anywhere.
  std::optional<cogrsim::Side> heading;
};

/// Fewest steps from cell to cell with which a robot that knew everything beforehand could have gone
/// from the start over the trigger to the goal.
///
/// The doors are open as soon as the trigger is reached, and a cell can be entered until its cube is
/// there. The search goes step by step: with T_k(s) the earliest time at which k steps can lead to
/// s = (cell, heading, errand),
///
///     T_k+1(s') = min over s of T_k(s) + turn(s, s') + step,  if before the cube in the cell of s'.
///
/// Since cubes never go, waiting wins nothing and of two ways of equal length the earlier is never the
/// worse: so the first k with a finite T_k at the goal is exact. No robot that moves from middle to
/// middle and keeps to this pace or a slower one can do with fewer. Nothing: there is no way.
std::optional<int> fewest_steps(const cogrsim::MazeModel& maze, const Task& task,
                                const std::vector<Cube>& cubes, const Pace& pace);

/// Whether the robot, being in `at`, could still do its task with these cells blocked: reach the
/// trigger with closed doors, unless it was there, and then the goal with open ones.
bool can_be_done(const cogrsim::MazeModel& maze, const Task& task, const Cell& at, bool triggered,
                 const std::vector<Cube>& cubes);

}  // namespace maze_referee
