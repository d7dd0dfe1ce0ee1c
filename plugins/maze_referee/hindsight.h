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

/// Fewest steps from cell to cell with which a robot that knew everything beforehand could have gone
/// from the start over the trigger to the goal.
///
/// Breadth-first search over (cell, errand). Each step takes `step_time` [s], turns none, and the
/// doors are open as soon as the trigger is reached; a cell can be entered before its cube is there.
/// Since cubes never go, waiting wins nothing, and the first arrival at a cell is also the best: the
/// search needs no time axis. No robot in this maze that moves from centre to centre, none faster
/// than cell / step_time, can do with fewer. Nothing: there is no way.
std::optional<int> fewest_steps(const cogrsim::MazeModel& maze, const Task& task,
                                const std::vector<Cube>& cubes, double step_time);

/// Whether the robot, being in `at`, could still do its task with these cells blocked: reach the
/// trigger with closed doors, unless it was there, and then the goal with open ones.
bool can_be_done(const cogrsim::MazeModel& maze, const Task& task, const Cell& at, bool triggered,
                 const std::vector<Cube>& cubes);

}  // namespace maze_referee
