// E. F. Moore, "The shortest path through a maze", Proceedings of the International Symposium on
// the Theory of Switching, Harvard University Press (1959), pp. 285-292.
#include <algorithm>

#include "held_grid.h"

namespace algorithms {
namespace {

/// The path with the fewest steps, regardless of their costs.
class BreadthFirst final : public HeldGrid {
 public:
  BreadthFirst(const cogrsim::Parameters&, std::uint64_t) {}

  cogrsim::Result<cogrsim::GridPath> plan(const cogrsim::Cell& start,
                                          const cogrsim::Cell& goal) override {
    if (cogrsim::Result<> checked = check_ends(start, goal); !checked) {
      return tl::unexpected(checked.error());
    }
    constexpr int kUnseen = -2, kFirst = -1;
    std::vector<int> before(static_cast<std::size_t>(grid_.size()), kUnseen);
    const auto seen_from = [&](int cell) -> int& { return before[cell]; };
    std::vector<int> queue{grid_.index(start)};
    std::vector<cogrsim::Grid::Step> steps;
    cogrsim::GridPath path;
    const int to = grid_.index(goal);
    seen_from(queue.front()) = kFirst;
    for (std::size_t i = 0; i < queue.size() && seen_from(to) == kUnseen; ++i) {
      ++path.expanded;
      grid_.steps(queue[i], steps);
      for (const cogrsim::Grid::Step& step : steps) {
        if (seen_from(step.to) != kUnseen) continue;
        seen_from(step.to) = queue[i];
        queue.push_back(step.to);
      }
    }
    if (seen_from(to) == kUnseen) return no_path(start, goal);
    for (int cell = to; cell != kFirst; cell = seen_from(cell)) {
      path.cells.push_back(grid_.cell(cell));
    }
    std::reverse(path.cells.begin(), path.cells.end());
    for (std::size_t i = 1; i < path.cells.size(); ++i) {
      path.cost += grid_.step_cost(path.cells[i - 1], path.cells[i]);
    }
    return path;
  }
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::BreadthFirst, cogrsim::GridPlanner, "breadth_first", version("1.0.0"),
                  summary("path with the fewest steps on a grid, regardless of their costs"))
