#include "hindsight.h"

#include <algorithm>

namespace maze_referee {

namespace {

using cogrsim::Grid;

using cogrsim::Side;

/// The target cell of a step; nullopt if the step is not possible.
std::optional<int> beyond(const Grid& grid, int from, Side side) {
  const Cell at = grid.cell(from);
  const Cell to{at.row + (side == Side::north) - (side == Side::south),
                at.column + (side == Side::east) - (side == Side::west)};
  if (!grid.contains(to) || !(grid.step_cost(at, to) < cogrsim::kBlocked)) return std::nullopt;
  return grid.index(to);
}

double turning(const Pace& pace, int heading, int side) {
  if (heading == side) return 0.0;
  // north 0, south 1, east 2, west 3: opposite directions are pairs.
  return heading / 2 == side / 2 ? pace.half : pace.quarter;
}

bool reaches(const Grid& grid, const Cell& from, const Cell& to) {
  const std::vector<int> all = grid.reachable(from);
  return std::find(all.begin(), all.end(), grid.index(to)) != all.end();
}

}  // namespace

std::optional<int> fewest_steps(const cogrsim::MazeModel& maze, const Task& task,
                                const std::vector<Cube>& cubes, const Pace& pace) {
  const Grid grids[] = {cogrsim::grid_of(maze, false), cogrsim::grid_of(maze, true)};
  const auto cells = static_cast<std::size_t>(grids[0].size());
  std::vector<double> blocked_from(cells, cogrsim::kBlocked);
  for (const Cube& cube : cubes) {
    double& since = blocked_from[grids[0].index(cube.cell)];
    since = std::min(since, cube.since);
  }

  // Time by errand, cell and heading; infinite: not reachable in k steps.
  const auto state = [&](int errand, int cell, int heading) {
    return (static_cast<std::size_t>(errand) * cells + static_cast<std::size_t>(cell)) * 4 +
           static_cast<std::size_t>(heading);
  };
  const int start = grids[0].index(task.start), goal = grids[0].index(task.goal);
  const int first = task.start == task.trigger ? 1 : 0;
  if (first == 1 && start == goal) return 0;
  std::vector<double> now(cells * 8, cogrsim::kBlocked);
  for (int heading = 0; heading < 4; ++heading) {
    if (pace.heading && static_cast<int>(*pace.heading) != heading) continue;
    now[state(first, start, heading)] = 0.0;
  }

  // A shortest path visits no cell twice in one errand.
  for (int count = 1; count <= 2 * static_cast<int>(cells); ++count) {
    std::vector<double> next(cells * 8, cogrsim::kBlocked);
    for (int errand = 0; errand < 2; ++errand) {
      const Grid& grid = grids[errand];
      for (int from = 0; from < grid.size(); ++from) {
        for (int side = 0; side < 4; ++side) {
          const auto to = beyond(grid, from, static_cast<Side>(side));
          if (!to) continue;
          double time = cogrsim::kBlocked;
          for (int heading = 0; heading < 4; ++heading) {
            time = std::min(time, now[state(errand, from, heading)] + turning(pace, heading, side));
          }
          time += pace.step;
          if (!(time < blocked_from[*to])) continue;
          const bool done = errand == 1 || grid.cell(*to) == task.trigger;
          if (done && *to == goal) return count;
          double& best = next[state(done ? 1 : 0, *to, side)];
          best = std::min(best, time);
        }
      }
    }
    now.swap(next);
  }
  return std::nullopt;
}

bool can_be_done(const cogrsim::MazeModel& maze, const Task& task, const Cell& at, bool triggered,
                 const std::vector<Cube>& cubes) {
  Grid closed = cogrsim::grid_of(maze, false), open = cogrsim::grid_of(maze, true);
  for (const Cube& cube : cubes) {
    for (Grid* grid : {&closed, &open}) (void)grid->set_cost(cube.cell, cogrsim::kBlocked);
  }
  if (!triggered && !reaches(closed, at, task.trigger)) return false;
  return reaches(open, triggered ? at : task.trigger, task.goal);
}

}  // namespace maze_referee
