// Common base of the grid planners: the grid, and the errors that all of them report.
#pragma once

#include <utility>

#include <fmt/format.h>

#include "cogrsim/algorithms/grid_planner.h"

namespace algorithms {

/// A planner whose only state is its grid.
class HeldGrid : public cogrsim::GridPlanner {
 public:
  void set_grid(cogrsim::Grid grid) override { grid_ = std::move(grid); }
  const cogrsim::Grid& grid() const override { return grid_; }
  cogrsim::Result<> set_cost(const cogrsim::Cell& cell, double cost) override {
    return grid_.set_cost(cell, cost);
  }
  cogrsim::Result<> set_cost(const cogrsim::GridEdge& edge, double cost) override {
    return grid_.set_cost(edge, cost);
  }

 protected:
  /// Checks that a cell is a valid start or goal.
  cogrsim::Result<> check_ends(const cogrsim::Cell& start, const cogrsim::Cell& goal) const {
    for (const auto& [name, cell] : {std::pair("start", start), std::pair("goal", goal)}) {
      if (!grid_.contains(cell)) {
        return cogrsim::fail(fmt::format("the {} {} is outside of the grid of {} x {}", name,
                                         to_string(cell), grid_.rows(), grid_.columns()));
      }
      if (grid_.cost(cell) == cogrsim::kBlocked) {
        return cogrsim::fail(fmt::format("the {} {} is a blocked cell", name, to_string(cell)));
      }
    }
    return {};
  }

  tl::unexpected<cogrsim::Error> no_path(const cogrsim::Cell& start,
                                         const cogrsim::Cell& goal) const {
    const std::size_t near_start = grid_.reachable(start).size();
    const std::size_t near_goal = grid_.reachable(goal).size();
    return cogrsim::fail(
        fmt::format("there is no path from {} to {}: of {} cells {} can be reached from the start "
                    "and {} from the goal, which is walled in on its side",
                    to_string(start), to_string(goal), grid_.size(), near_start, near_goal),
        "", "open an edge between the two, or choose another goal", cogrsim::kNoPath);
  }

  cogrsim::Grid grid_;
};

}  // namespace algorithms
