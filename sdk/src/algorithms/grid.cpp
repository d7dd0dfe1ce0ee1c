#include "cogrsim/algorithms/grid.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"

namespace cogrsim {

namespace {

constexpr double kDiagonal = 1.4142135623730951;

const char* name_of(Side side) {
  switch (side) {
    case Side::north:
      return "north";
    case Side::south:
      return "south";
    case Side::east:
      return "east";
    case Side::west:
      return "west";
  }
  return "?";
}

Cell beside(const Cell& cell, Side side) {
  switch (side) {
    case Side::north:
      return {cell.row + 1, cell.column};
    case Side::south:
      return {cell.row - 1, cell.column};
    case Side::east:
      return {cell.row, cell.column + 1};
    case Side::west:
      return {cell.row, cell.column - 1};
  }
  return cell;
}

Result<> check_cost(const std::string& what, double cost) {
  if (cost > 0.0) return {};
  return fail(fmt::format("the cost of {} is {}, but must be above 0, or infinite to block it",
                          what, cost));
}

}  // namespace

std::string to_string(const Cell& cell) { return fmt::format("r{}c{}", cell.row, cell.column); }

Grid::Grid(int rows, int columns, GridMoves moves) : rows_(rows), columns_(columns), moves_(moves) {
  const auto r = static_cast<std::size_t>(rows), c = static_cast<std::size_t>(columns);
  cells_.assign(r * c, 1.0);
  vertical_.assign(r * (c + 1), 1.0);
  horizontal_.assign((r + 1) * c, 1.0);
  for (std::size_t row = 0; row < r; ++row) {
    vertical_[row * (c + 1)] = vertical_[row * (c + 1) + c] = kBlocked;
  }
  for (std::size_t column = 0; column < c; ++column) {
    horizontal_[column] = horizontal_[r * c + column] = kBlocked;
  }
}

double& Grid::edge_at(const GridEdge& edge) {
  const int row = edge.cell.row, column = edge.cell.column;
  const bool upright = edge.side == Side::east || edge.side == Side::west;
  const int at = upright ? row * (columns_ + 1) + column + (edge.side == Side::east ? 1 : 0)
                         : (row + (edge.side == Side::north ? 1 : 0)) * columns_ + column;
  return (upright ? vertical_ : horizontal_)[at];
}

double Grid::cost(const GridEdge& edge) const {
  switch (edge.side) {
    case Side::north:
      return horizontal(edge.cell.row + 1, edge.cell.column);
    case Side::south:
      return horizontal(edge.cell.row, edge.cell.column);
    case Side::east:
      return vertical(edge.cell.row, edge.cell.column + 1);
    case Side::west:
      return vertical(edge.cell.row, edge.cell.column);
  }
  return kBlocked;
}

Result<> Grid::set_cost(const Cell& cell, double cost) {
  if (!contains(cell)) {
    return fail(
        fmt::format("cell {} is outside of the grid of {} x {}", to_string(cell), rows_, columns_));
  }
  if (Result<> checked = check_cost("cell " + to_string(cell), cost); !checked) return checked;
  cells_[index(cell)] = cost;
  return {};
}

Result<> Grid::set_cost(const GridEdge& edge, double cost) {
  const std::string what =
      fmt::format("the edge {} of cell {}", name_of(edge.side), to_string(edge.cell));
  if (!contains(edge.cell)) {
    return fail(fmt::format("{} is outside of the grid of {} x {}", what, rows_, columns_));
  }
  if (!contains(beside(edge.cell, edge.side))) {
    return fail(fmt::format("{} is an outer edge of the grid of {} x {}, which is closed", what,
                            rows_, columns_));
  }
  if (Result<> checked = check_cost(what, cost); !checked) return checked;
  edge_at(edge) = cost;
  return {};
}

double Grid::step_cost(const Cell& a, const Cell& b) const {
  const int up = b.row - a.row, right = b.column - a.column;
  if (std::abs(up) > 1 || std::abs(right) > 1 || (up == 0 && right == 0)) return kBlocked;
  const double mean = 0.5 * (cost(a) + cost(b));
  if (right == 0) return mean * horizontal(std::max(a.row, b.row), a.column);
  if (up == 0) return mean * vertical(a.row, std::max(a.column, b.column));
  if (moves_ == GridMoves::four) return kBlocked;
  if (cost(Cell{a.row, b.column}) == kBlocked || cost(Cell{b.row, a.column}) == kBlocked) {
    return kBlocked;
  }
  const int line_x = std::max(a.column, b.column), line_y = std::max(a.row, b.row);
  const double edge = std::max({vertical(a.row, line_x), vertical(b.row, line_x),
                                horizontal(line_y, a.column), horizontal(line_y, b.column)});
  return kDiagonal * mean * edge;
}

void Grid::steps(int from, std::vector<Step>& out) const {
  static constexpr int kSteps[8][2] = {{1, 0}, {0, 1},  {-1, 0},  {0, -1},
                                       {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};  // up, right
  out.clear();
  const Cell here = cell(from);
  const int count = moves_ == GridMoves::four ? 4 : 8;
  for (int i = 0; i < count; ++i) {
    const Cell there{here.row + kSteps[i][0], here.column + kSteps[i][1]};
    if (!contains(there)) continue;
    const double price = step_cost(here, there);
    if (price < kBlocked) out.push_back({index(there), price});
  }
}

double Grid::least_cost() const {
  double cheapest_cell = kBlocked, cheapest_edge = kBlocked;
  for (const double cost : cells_) cheapest_cell = std::min(cheapest_cell, cost);
  for (const double cost : vertical_) cheapest_edge = std::min(cheapest_edge, cost);
  for (const double cost : horizontal_) cheapest_edge = std::min(cheapest_edge, cost);
  return cheapest_cell * cheapest_edge;
}

std::vector<int> Grid::reachable(const Cell& from) const {
  std::vector<int> found;
  if (!contains(from) || cost(from) == kBlocked) return found;
  std::vector<char> seen(static_cast<std::size_t>(size()), 0);
  std::vector<Step> next;
  found.push_back(index(from));
  seen[found.front()] = 1;
  for (std::size_t i = 0; i < found.size(); ++i) {
    steps(found[i], next);
    for (const Step& step : next) {
      char& mark = seen[step.to];
      if (mark == 0) found.push_back(step.to);
      mark = 1;
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

Grid grid_of(const MazeModel& maze, bool doors_open, GridMoves moves) {
  Grid grid(maze.rows, maze.columns, moves);
  const auto passable = [&](int what) {
    return what == MazeModel::kOpen || (what >= 0 && doors_open);
  };
  // Only inner edges, so that set_cost() cannot fail.
  for (int row = 0; row < maze.rows; ++row) {
    for (int column = 0; column < maze.columns; ++column) {
      if (column + 1 < maze.columns && !passable(maze.east(row, column))) {
        static_cast<void>(grid.set_cost(GridEdge{{row, column}, Side::east}, kBlocked));
      }
      if (row + 1 < maze.rows && !passable(maze.north(row, column))) {
        static_cast<void>(grid.set_cost(GridEdge{{row, column}, Side::north}, kBlocked));
      }
    }
  }
  return grid;
}

std::vector<GridEdge> edges_of_door(const MazeModel& maze, int door) {
  std::vector<GridEdge> edges;
  if (door < 0) return edges;
  for (int row = 0; row < maze.rows; ++row) {
    for (int column = 0; column < maze.columns; ++column) {
      if (column + 1 < maze.columns && maze.east(row, column) == door) {
        edges.push_back({{row, column}, Side::east});
      }
      if (row + 1 < maze.rows && maze.north(row, column) == door) {
        edges.push_back({{row, column}, Side::north});
      }
    }
  }
  return edges;
}

std::optional<Cell> cell_at(const MazeModel& maze, const Vec3& p_W) {
  const Vec3 p_M = maze.X_WM.inverse() * p_W;
  const double row = std::floor(p_M.y() / maze.cell), column = std::floor(p_M.x() / maze.cell);
  // This form of the comparison makes NaN lie outside.
  if (!(row >= 0.0 && row < maze.rows && column >= 0.0 && column < maze.columns)) return {};
  return Cell{static_cast<int>(row), static_cast<int>(column)};
}

Vec3 centre_of(const MazeModel& maze, const Cell& cell) {
  return maze.X_WM * maze.centre(cell.row, cell.column);
}

Result<Cell> find_cell(const MazeModel& maze, const std::string& name) {
  std::vector<std::string> names;
  for (const MazeModel::NamedCell& named : maze.named_cells) {
    if (named.name == name) return Cell{named.row, named.column};
    names.push_back(named.name);
  }
  for (int row = 0; row < maze.rows; ++row) {
    for (int column = 0; column < maze.columns; ++column) {
      if (to_string(Cell{row, column}) == name) return Cell{row, column};
    }
  }
  const std::string near = nearest_name(name, names);
  return fail(fmt::format("maze '{}' has no cell '{}'{}; it has {}{}r0c0 to {}", maze.name, name,
                          near.empty() ? "" : fmt::format(", did you mean '{}'?", near),
                          fmt::join(names, ", "), names.empty() ? "" : ", ",
                          to_string(Cell{maze.rows - 1, maze.columns - 1})));
}

}  // namespace cogrsim
