// Best-first search on a grid: Dijkstra's algorithm without a heuristic, A* with one.
#pragma once

#include <algorithm>
#include <cmath>
#include <queue>
#include <vector>

#include "held_grid.h"

namespace algorithms {

/// The distance between two cells without obstacles, in cell lengths: the Manhattan distance with
/// four moves, the octile distance with eight.
inline double free_distance(const cogrsim::Cell& a, const cogrsim::Cell& b,
                            cogrsim::GridMoves moves) {
  const double rows = std::abs(a.row - b.row), columns = std::abs(a.column - b.column);
  if (moves == cogrsim::GridMoves::four) return rows + columns;
  const double diagonal = std::min(rows, columns);
  return rows + columns - (2.0 - std::sqrt(2.0)) * diagonal;
}

class BestFirst : public HeldGrid {
 public:
  /// Expands cells in the order of the cost so far plus `least_left(cell)`, which must never exceed
  /// the remaining cost. Of equal ones the cell farthest from the start is first, then the lowest
  /// index.
  template <class Heuristic>
  cogrsim::Result<cogrsim::GridPath> search(const cogrsim::Cell& start, const cogrsim::Cell& goal,
                                            Heuristic&& least_left) const {
    if (cogrsim::Result<> checked = check_ends(start, goal); !checked) {
      return tl::unexpected(checked.error());
    }
    struct Entry {
      double total, so_far;
      int cell;
      bool operator<(const Entry& other) const {  // the largest is popped first
        if (total != other.total) return total > other.total;
        if (so_far != other.so_far) return so_far < other.so_far;
        return cell > other.cell;
      }
    };
    const auto cells = static_cast<std::size_t>(grid_.size());
    std::vector<double> best(cells, cogrsim::kBlocked);
    std::vector<int> before(cells, -1);
    std::priority_queue<Entry> open;
    std::vector<cogrsim::Grid::Step> steps;
    cogrsim::GridPath path;
    const int from = grid_.index(start), to = grid_.index(goal);
    best[from] = 0.0;
    open.push({least_left(start), 0.0, from});
    while (!open.empty()) {
      const Entry entry = open.top();
      open.pop();
      // A better path to it was found after it had been queued.
      if (entry.so_far > best[entry.cell]) continue;
      if (entry.cell == to) break;
      ++path.expanded;
      grid_.steps(entry.cell, steps);
      for (const cogrsim::Grid::Step& step : steps) {
        const double cost = entry.so_far + step.cost;
        double& known = best[step.to];
        if (!(cost < known)) continue;
        known = cost;
        before[step.to] = entry.cell;
        open.push({cost + least_left(grid_.cell(step.to)), cost, step.to});
      }
    }
    path.cost = best[to];
    if (path.cost == cogrsim::kBlocked) return no_path(start, goal);
    for (int cell = to; cell >= 0; cell = before[cell]) {
      path.cells.push_back(grid_.cell(cell));
    }
    std::reverse(path.cells.begin(), path.cells.end());
    return path;
  }
};

}  // namespace algorithms
