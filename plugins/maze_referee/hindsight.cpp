#include "hindsight.h"

#include <algorithm>
#include <queue>

namespace maze_referee {

namespace {

using cogrsim::Grid;

bool reaches(const Grid& grid, const Cell& from, const Cell& to) {
  const std::vector<int> all = grid.reachable(from);
  return std::find(all.begin(), all.end(), grid.index(to)) != all.end();
}

}  // namespace

std::optional<int> fewest_steps(const cogrsim::MazeModel& maze, const Task& task,
                                const std::vector<Cube>& cubes, double step_time) {
  const Grid closed = cogrsim::grid_of(maze, false), open = cogrsim::grid_of(maze, true);
  const auto cells = static_cast<std::size_t>(closed.size());
  std::vector<double> blocked_from(cells, cogrsim::kBlocked);
  for (const Cube& cube : cubes) {
    double& since = blocked_from[static_cast<std::size_t>(closed.index(cube.cell))];
    since = std::min(since, cube.since);
  }

  std::vector<int> steps(2 * cells, -1);  // by errand, then cell
  std::queue<std::size_t> waiting;
  const auto visit = [&](const Cell& cell, std::size_t errand, int count) {
    if (cell == task.trigger) errand = 1;
    const std::size_t node = errand * cells + static_cast<std::size_t>(closed.index(cell));
    if (steps[node] >= 0) return;
    steps[node] = count;
    waiting.push(node);
  };
  visit(task.start, 0, 0);
  std::vector<Grid::Step> next;
  while (!waiting.empty()) {
    const std::size_t node = waiting.front();
    waiting.pop();
    const std::size_t errand = node / cells;
    const auto index = static_cast<int>(node % cells);
    const int count = steps[node];
    if (errand == 1 && closed.cell(index) == task.goal) return count;
    (errand == 1 ? open : closed).steps(index, next);
    for (const Grid::Step& step : next) {
      if ((count + 1) * step_time < blocked_from[static_cast<std::size_t>(step.to)]) {
        visit(closed.cell(step.to), errand, count + 1);
      }
    }
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
