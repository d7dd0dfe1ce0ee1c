// S. Koenig, M. Likhachev, "D* Lite", Proceedings of the AAAI Conference (2002), pp. 476-483: the
// first version (figure 3), with the names of the paper.
//
// It searches from the goal, so that its data stay valid while the vehicle moves, and repairs only
// the cells that a change affects. g is the previous cost to the goal, and rhs the cost that
// follows from g of the neighbours; if the two differ, the cell is in the queue.
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "best_first.h"

namespace algorithms {
namespace {

using cogrsim::Cell;
using cogrsim::Grid;
using cogrsim::GridEdge;
using cogrsim::GridPath;
using cogrsim::kBlocked;

class DStarLite final : public HeldGrid {
 public:
  DStarLite(const cogrsim::Parameters&, std::uint64_t) {}

  void set_grid(Grid grid) override {
    HeldGrid::set_grid(std::move(grid));
    goal_ = -1;
  }

  cogrsim::Result<> set_cost(const Cell& cell, double cost) override {
    const double before = grid_.contains(cell) ? grid_.cost(cell) : cost;
    cogrsim::Result<> done = grid_.set_cost(cell, cost);
    // The diagonal steps past the cell are also between neighbours of it.
    if (done && cost != before)
      changed(cell.row - 1, cell.row + 1, cell.column - 1, cell.column + 1);
    return done;
  }

  cogrsim::Result<> set_cost(const GridEdge& edge, double cost) override {
    const double before = grid_.contains(edge.cell) ? grid_.cost(edge) : cost;
    cogrsim::Result<> done = grid_.set_cost(edge, cost);
    if (!done || cost == before) return done;
    const int row = edge.cell.row, column = edge.cell.column;
    // The two cells of the edge, and with eight moves those of the diagonal steps around its ends.
    const int wide = grid_.moves() == cogrsim::GridMoves::eight ? 1 : 0;
    switch (edge.side) {
      case cogrsim::Side::north:
        changed(row, row + 1, column - wide, column + wide);
        break;
      case cogrsim::Side::south:
        changed(row - 1, row, column - wide, column + wide);
        break;
      case cogrsim::Side::east:
        changed(row - wide, row + wide, column, column + 1);
        break;
      case cogrsim::Side::west:
        changed(row - wide, row + wide, column - 1, column);
        break;
    }
    return done;
  }

  cogrsim::Result<GridPath> plan(const Cell& start, const Cell& goal) override {
    if (cogrsim::Result<> checked = check_ends(start, goal); !checked) {
      return tl::unexpected(checked.error());
    }
    expanded_ = 0;
    start_ = grid_.index(start);
    // If a cost falls below the previous minimum, the heuristic is not admissible any more.
    if (grid_.index(goal) != goal_ || grid_.least_cost() < least_) {
      initialize(grid_.index(goal));
    } else {
      if (start_ != last_start_) km_ += heuristic(last_start_, start_);
      for (const int cell : changed_) update_vertex(cell);
    }
    last_start_ = start_;
    changed_.clear();
    compute_shortest_path();
    return read_path(start, goal);
  }

 private:
  using Key = std::pair<double, double>;
  using Entry = std::tuple<double, double, int>;  // key, cell

  struct Vertex {
    double g = kBlocked, rhs = kBlocked;
    Key key{};  // its key in the queue
    bool queued = false;
  };

  Vertex& at(int cell) { return vertices_[cell]; }

  void changed(int row_from, int row_to, int column_from, int column_to) {
    if (goal_ < 0) return;
    for (int row = row_from; row <= row_to; ++row) {
      for (int column = column_from; column <= column_to; ++column) {
        if (grid_.contains({row, column})) changed_.insert(grid_.index({row, column}));
      }
    }
  }

  /// Reduced by more than the rounding errors, so that it is consistent in floating point and keys
  /// never decrease by rounding.
  double heuristic(int a, int b) const {
    if (!std::isfinite(least_)) return 0.0;
    return (1.0 - 1e-9) * least_ * free_distance(grid_.cell(a), grid_.cell(b), grid_.moves());
  }

  Key calculate_key(int cell) {
    const double least = std::min(at(cell).g, at(cell).rhs);
    return {least + heuristic(start_, cell) + km_, least};
  }

  void initialize(int goal) {
    goal_ = goal;
    km_ = 0.0;
    least_ = grid_.least_cost();
    queue_.clear();
    vertices_.assign(static_cast<std::size_t>(grid_.size()), Vertex{});
    at(goal).rhs = 0.0;
    insert(goal);
  }

  void insert(int cell) {
    Vertex& vertex = at(cell);
    vertex.key = calculate_key(cell);
    vertex.queued = true;
    queue_.insert({vertex.key.first, vertex.key.second, cell});
  }

  void remove(int cell) {
    Vertex& vertex = at(cell);
    queue_.erase({vertex.key.first, vertex.key.second, cell});
    vertex.queued = false;
  }

  void update_vertex(int cell) {
    Vertex& vertex = at(cell);
    if (cell != goal_) {
      vertex.rhs = kBlocked;
      grid_.steps(cell, around_);
      for (const Grid::Step& step : around_) {
        vertex.rhs = std::min(vertex.rhs, step.cost + at(step.to).g);
      }
    }
    if (vertex.queued) remove(cell);
    if (vertex.g != vertex.rhs) insert(cell);
  }

  void compute_shortest_path() {
    while (!queue_.empty()) {
      const auto [first, second, cell] = *queue_.begin();
      const Key old{first, second};
      const Vertex& start = at(start_);
      if (!(old < calculate_key(start_)) && start.rhs == start.g) break;
      remove(cell);
      if (old < calculate_key(cell)) {
        insert(cell);
        continue;
      }
      ++expanded_;
      Vertex& vertex = at(cell);
      grid_.steps(cell, next_);
      if (vertex.g > vertex.rhs) {
        vertex.g = vertex.rhs;
      } else {
        vertex.g = kBlocked;
        update_vertex(cell);
      }
      for (const Grid::Step& step : next_) update_vertex(step.to);
    }
  }

  cogrsim::Result<GridPath> read_path(const Cell& start, const Cell& goal) {
    if (at(start_).g == kBlocked) return no_path(start, goal);
    GridPath path;
    path.expanded = expanded_;
    path.cells.push_back(start);
    for (int cell = start_; cell != goal_;) {
      grid_.steps(cell, around_);
      const Grid::Step* best = nullptr;
      for (const Grid::Step& step : around_) {
        if (!best || step.cost + at(step.to).g < best->cost + at(best->to).g) best = &step;
      }
      // Costs are above 0, so g decreases with every step and the path ends at the goal.
      path.cost += best->cost;
      cell = best->to;
      path.cells.push_back(grid_.cell(cell));
    }
    return path;
  }

  int start_ = -1, last_start_ = -1, goal_ = -1;  // goal_ -1: no search yet
  double km_ = 0.0;
  double least_ = kBlocked;  // smallest cost of the grid at the start of the search
  std::size_t expanded_ = 0;
  std::vector<Vertex> vertices_;
  std::set<Entry> queue_;
  std::set<int> changed_;  // cells whose steps changed since the last plan
  std::vector<Grid::Step> around_, next_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::DStarLite, cogrsim::GridPlanner, "d_star_lite", version("1.0.0"),
                  summary("cheapest path on a grid, repaired where the grid changed"))
