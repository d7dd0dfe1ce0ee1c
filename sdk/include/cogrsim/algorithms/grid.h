// A grid of cells as grid planners see it: every cell has a cost, and so has every edge between two
// neighbours, because walls stand between cells.
//
// Rows count from the south, columns from the west, as in MazeModel.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim {

struct Cell {
  int row = 0;
  int column = 0;
};
inline bool operator==(const Cell& a, const Cell& b) {
  return a.row == b.row && a.column == b.column;
}
inline bool operator!=(const Cell& a, const Cell& b) { return !(a == b); }

/// "r2c5", the name a maze gives its cells.
COGRSIM_API std::string to_string(const Cell& cell);

/// Which neighbour of a cell.
enum class Side { north, south, east, west };

/// What stands between a cell and its neighbour on one side.
struct GridEdge {
  Cell cell;
  Side side = Side::north;
};

/// Whether a step may go diagonally.
enum class GridMoves { four, eight };

/// A cell or edge of this cost cannot be passed.
inline constexpr double kBlocked = std::numeric_limits<double>::infinity();

/// The cost of a step from cell a to its neighbour b is
///
///     length * edge * (cost(a) + cost(b)) / 2,
///
/// with length 1 straight and sqrt(2) diagonally. A diagonal step passes a corner where four edges
/// meet: it counts the dearest of them, and is possible only if all four and both cells beside it
/// can be passed, so that no corner is cut. Costs are the same in both directions. All costs begin
/// at 1, the outer edges at kBlocked: a path's cost is then its length in cells.
class COGRSIM_API Grid {
 public:
  Grid() = default;
  /// Precondition: rows, columns >= 0. A grid without cells is possible; no plan is found in it.
  Grid(int rows, int columns, GridMoves moves = GridMoves::four);

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int size() const { return rows_ * columns_; }
  GridMoves moves() const { return moves_; }

  bool contains(const Cell& cell) const {
    return cell.row >= 0 && cell.row < rows_ && cell.column >= 0 && cell.column < columns_;
  }
  /// row * columns + column. Precondition: contains(cell).
  int index(const Cell& cell) const { return cell.row * columns_ + cell.column; }
  Cell cell(int index) const { return {index / columns_, index % columns_}; }

  /// Precondition: contains(cell).
  double cost(const Cell& cell) const { return cells_[static_cast<std::size_t>(index(cell))]; }
  /// Precondition: contains(edge.cell).
  double cost(const GridEdge& edge) const;

  /// Errors: outside of the grid, not above 0, NaN; of an edge also: the grid's rim.
  Result<> set_cost(const Cell& cell, double cost);
  Result<> set_cost(const GridEdge& edge, double cost);

  /// Cost of one step; kBlocked when b is no neighbour of a or cannot be reached.
  /// Precondition: contains(a), contains(b).
  double step_cost(const Cell& a, const Cell& b) const;

  struct Step {
    int to = 0;  ///< index()
    double cost = 0.0;
  };
  /// The steps possible from a cell: at most 8, in a fixed order. `out` is overwritten.
  void steps(int from, std::vector<Step>& out) const;

  /// The least a step of length 1 can cost anywhere in the grid now; kBlocked if there is none.
  double least_cost() const;

  /// Cells that can be reached from here, itself among them, by index; empty if it is blocked or
  /// outside.
  std::vector<int> reachable(const Cell& from) const;

 private:
  double& edge_at(const GridEdge& edge);
  double vertical(int row, int line) const {
    return vertical_[static_cast<std::size_t>(row * (columns_ + 1) + line)];
  }
  double horizontal(int line, int column) const {
    return horizontal_[static_cast<std::size_t>(line * columns_ + column)];
  }

  int rows_ = 0, columns_ = 0;
  GridMoves moves_ = GridMoves::four;
  std::vector<double> cells_;       // rows x columns
  std::vector<double> vertical_;    // rows x (columns + 1), as MazeModel::vertical
  std::vector<double> horizontal_;  // (rows + 1) x columns
};

/// The plan of a maze: walls are blocked, doors too unless `doors_open`.
COGRSIM_API Grid grid_of(const MazeModel& maze, bool doors_open = false,
                         GridMoves moves = GridMoves::four);

/// The edges where a door of the maze stands (an index into SceneModel::doors): those to open in a
/// planner when it opens. Empty: no such door here.
COGRSIM_API std::vector<GridEdge> edges_of_door(const MazeModel& maze, int door);

/// The cell over which a point of the world is; nothing outside of the maze or for NaN.
COGRSIM_API std::optional<Cell> cell_at(const MazeModel& maze, const Vec3& p_W);

/// The middle of a cell's floor in the world [m].
COGRSIM_API Vec3 centre_of(const MazeModel& maze, const Cell& cell);

/// A named place, or a cell as "r2c5". Errors: unknown, with the nearest name.
COGRSIM_API Result<Cell> find_cell(const MazeModel& maze, const std::string& name);

}  // namespace cogrsim
