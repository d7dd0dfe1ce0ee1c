// P. E. Hart, N. J. Nilsson, B. Raphael, "A formal basis for the heuristic determination of minimum
// cost paths", IEEE Transactions on Systems Science and Cybernetics 4 (1968), pp. 100-107.
#include <cmath>

#include "best_first.h"

namespace algorithms {
namespace {

/// The heuristic is `weight` times the obstacle-free distance times the smallest cost of a step in
/// the grid, which never exceeds the remaining cost. With weight w a path costs at most w times the
/// optimum (I. Pohl, "Heuristic search viewed as path finding in a graph", Artificial Intelligence
/// 1 (1970)).
class AStar final : public BestFirst {
 public:
  AStar(const cogrsim::Parameters& parameters, std::uint64_t)
      : weight_(std::get<double>(parameters.at("weight"))) {}

  cogrsim::Result<cogrsim::GridPath> plan(const cogrsim::Cell& start,
                                          const cogrsim::Cell& goal) override {
    const double least = grid_.least_cost();
    const double scale = std::isfinite(least) ? weight_ * least : 0.0;
    return search(start, goal, [&](const cogrsim::Cell& cell) {
      return scale * free_distance(cell, goal, grid_.moves());
    });
  }

 private:
  double weight_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::AStar, cogrsim::GridPlanner, "a_star", version("1.0.0"),
                  summary("cheapest path on a grid, searched towards the goal"),
                  parameter("weight", 1.0, "1",
                            "of the heuristic; above 1 the search is faster, and the path costs at "
                            "most that much more")
                      .range(1.0, 100.0))
