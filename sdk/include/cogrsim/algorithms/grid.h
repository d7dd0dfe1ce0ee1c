// The grid of the grid planners. Every cell has a cost, and so has every edge between two
// neighbours, because walls are between cells.
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

/// A cell of a grid.
struct Cell {
  int row = 0;
  int column = 0;
};
inline bool operator==(const Cell& a, const Cell& b) {
  return a.row == b.row && a.column == b.column;
}
inline bool operator!=(const Cell& a, const Cell& b) { return !(a == b); }

/// Name of a cell as in a maze: "r2c5".
COGRSIM_API std::string to_string(const Cell& cell);

/// A side of a cell.
enum class Side { north, south, east, west };

/// The edge between a cell and its neighbour on one side.
struct GridEdge {
  Cell cell;
  Side side = Side::north;
};

/// Allowed steps: to four neighbours, or also diagonally to eight.
enum class GridMoves { four, eight };

/// A cell or edge of this cost cannot be passed.
inline constexpr double kBlocked = std::numeric_limits<double>::infinity();

/// A grid with costs. The cost of a step from cell a to its neighbour b is
///
///     length * edge * (cost(a) + cost(b)) / 2,
///
/// with the length 1 for a straight step and sqrt(2) for a diagonal one. A diagonal step passes a
/// corner of four edges: its edge cost is the largest of the four, and it is possible only if all
/// four edges and both adjacent cells can be passed, so that no corner is cut. Costs are the same
/// in both directions. Initially all costs are 1 and those of the outer edges kBlocked, so that the
/// cost of a path is its length in cells.
class COGRSIM_API Grid {
 public:
  Grid() = default;
  /// Precondition: rows >= 0, columns >= 0. A grid without cells is allowed; it has no plans.
  Grid(int rows, int columns, GridMoves moves = GridMoves::four);

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int size() const { return rows_ * columns_; }
  GridMoves moves() const { return moves_; }

  bool contains(const Cell& cell) const {
    return cell.row >= 0 && cell.row < rows_ && cell.column >= 0 && cell.column < columns_;
  }
  /// Index of a cell: row * columns + column. Precondition: contains(cell).
  int index(const Cell& cell) const { return cell.row * columns_ + cell.column; }
  /// The cell with this index.
  Cell cell(int index) const { return {index / columns_, index % columns_}; }

  /// Cost of a cell. Precondition: contains(cell).
  double cost(const Cell& cell) const { return cells_[index(cell)]; }
  /// Cost of an edge. Precondition: contains(edge.cell).
  double cost(const GridEdge& edge) const;

  /// Sets the cost of a cell or an edge, > 0 or kBlocked. Errors: the cell is outside of the grid,
  /// the cost is NaN or not above 0, or the edge is an outer edge.
  Result<> set_cost(const Cell& cell, double cost);
  Result<> set_cost(const GridEdge& edge, double cost);

  /// Cost of the step from a to b; kBlocked if b is not a neighbour of a or the step is not
  /// possible. Precondition: contains(a), contains(b).
  double step_cost(const Cell& a, const Cell& b) const;

  /// A possible step.
  struct Step {
    int to = 0;  ///< index of the neighbour
    double cost = 0.0;
  };
  /// Writes the possible steps from the cell with the index `from` to `out`: at most 8, in a fixed
  /// order.
  void steps(int from, std::vector<Step>& out) const;

  /// Lower bound of the cost of a step of length 1 in the current grid; kBlocked if none is
  /// possible.
  double least_cost() const;

  /// Indices of the cells that can be reached from `from`, including itself; empty if it is blocked
  /// or outside of the grid.
  std::vector<int> reachable(const Cell& from) const;

 private:
  double& edge_at(const GridEdge& edge);
  double vertical(int row, int line) const { return vertical_[row * (columns_ + 1) + line]; }
  double horizontal(int line, int column) const { return horizontal_[line * columns_ + column]; }

  int rows_ = 0, columns_ = 0;
  GridMoves moves_ = GridMoves::four;
  std::vector<double> cells_;       // rows x columns
  std::vector<double> vertical_;    // rows x (columns + 1), as MazeModel::vertical
  std::vector<double> horizontal_;  // (rows + 1) x columns
};

/// The grid of a maze. Walls are blocked; doors are blocked unless `doors_open`.
COGRSIM_API Grid grid_of(const MazeModel& maze, bool doors_open = false,
                         GridMoves moves = GridMoves::four);

/// The edges of a door of the maze, whose costs change when it opens; empty if the maze does not
/// have the door. `door` is an index into SceneModel::doors.
COGRSIM_API std::vector<GridEdge> edges_of_door(const MazeModel& maze, int door);

/// The cell below a point of the world [m]; nullopt outside of the maze or for NaN.
COGRSIM_API std::optional<Cell> cell_at(const MazeModel& maze, const Vec3& p_W);

/// Centre of the floor of a cell in the world [m].
COGRSIM_API Vec3 centre_of(const MazeModel& maze, const Cell& cell);

/// The cell with a name of the maze, or with a name such as "r2c5". Errors: the name is unknown,
/// with the most similar one.
COGRSIM_API Result<Cell> find_cell(const MazeModel& maze, const std::string& name);

}  // namespace cogrsim
