// The interface of grid planners, such as "a_star", "dijkstra", "breadth_first" and "d_star_lite".
#pragma once

#include <cstddef>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/algorithms/grid.h"

namespace cogrsim {

/// A path on a grid.
struct GridPath {
  std::vector<Cell> cells;   ///< from start to goal, inclusive; one cell if they are equal
  double cost = 0.0;         ///< sum of Grid::step_cost() along the path
  std::size_t expanded = 0;  ///< number of expanded cells, a measure of the computation
};

/// Error::code if start and goal are not connected.
inline constexpr const char* kNoPath = "no-path";

/// Finds the path of least cost from cell to cell, and replans when the grid changes.
///
///     planner->set_grid(grid_of(maze));
///     auto path = planner->plan({0, 0}, {7, 7});
///     planner->set_cost(GridEdge{{3, 4}, Side::east}, kBlocked);  // an obstacle was seen
///     path = planner->plan({3, 4}, {7, 7});
///
/// The cost of a plan does not depend on earlier calls. An incremental planner is faster if the
/// goal is the same and few costs have changed. The choice among paths of the same cost is
/// deterministic: the same sequence of calls gives the same path.
class GridPlanner {
 public:
  static constexpr const char* kFamily = "grid-planner";
  virtual ~GridPlanner() = default;

  /// Replaces the grid and discards all data of the old one.
  virtual void set_grid(Grid grid) = 0;
  virtual const Grid& grid() const = 0;

  /// Changes the cost of one cell or edge of the grid. Errors: as Grid::set_cost().
  virtual Result<> set_cost(const Cell& cell, double cost) = 0;
  virtual Result<> set_cost(const GridEdge& edge, double cost) = 0;

  /// Plans a path. Errors: start or goal is outside of the grid or blocked, or no path exists (code
  /// kNoPath), with the numbers of cells that can be reached from both ends.
  virtual Result<GridPath> plan(const Cell& start, const Cell& goal) = 0;
};

}  // namespace cogrsim
