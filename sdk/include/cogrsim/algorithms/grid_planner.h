// Planners on grids: "a_star", "dijkstra", "breadth_first", "d_star_lite", and yours.
#pragma once

#include <cstddef>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/algorithms/grid.h"

namespace cogrsim {

struct GridPath {
  std::vector<Cell> cells;   ///< from start to goal, both included; one if they are the same
  double cost = 0.0;         ///< sum of Grid::step_cost along it
  std::size_t expanded = 0;  ///< cells whose neighbours were looked at for this plan: the work done
};

/// Error::code of a plan that failed because start and goal are not connected.
inline constexpr const char* kNoWay = "no-way";

/// Finds a way from cell to cell, and again when the grid turns out to be different.
///
///     planner->set_grid(grid_of(maze));
///     auto path = planner->plan({0, 0}, {7, 7});
///     planner->set_cost(GridEdge{{3, 4}, Side::east}, kBlocked);  // an obstacle was seen
///     path = planner->plan({3, 4}, {7, 7});
///
/// Planners answer alike whatever was asked before; an incremental one answers sooner when the goal
/// stays and little has changed. Of ways that cost the same the planner's choice is fixed: the same
/// calls give the same path.
class GridPlanner {
 public:
  static constexpr const char* kFamily = "grid-planner";
  virtual ~GridPlanner() = default;

  /// Replaces the grid; what was learnt from the old one is forgotten.
  virtual void set_grid(Grid grid) = 0;
  virtual const Grid& grid() const = 0;

  /// Changes one cell or edge of the grid. Errors as of Grid::set_cost.
  virtual Result<> set_cost(const Cell& cell, double cost) = 0;
  virtual Result<> set_cost(const GridEdge& edge, double cost) = 0;

  /// Errors: start or goal outside of the grid or blocked; no way (code kNoWay), with the numbers
  /// of cells that can be reached from either end.
  virtual Result<GridPath> plan(const Cell& start, const Cell& goal) = 0;
};

}  // namespace cogrsim
