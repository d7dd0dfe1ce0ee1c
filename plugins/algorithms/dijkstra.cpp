// E. W. Dijkstra, "A note on two problems in connexion with graphs", Numerische Mathematik 1 (1959),
// pp. 269-271.
#include "best_first.h"

namespace algorithms {
namespace {

class Dijkstra final : public BestFirst {
 public:
  Dijkstra(const cogrsim::Parameters&, std::uint64_t) {}
  cogrsim::Result<cogrsim::GridPath> plan(const cogrsim::Cell& start,
                                          const cogrsim::Cell& goal) override {
    return search(start, goal, [](const cogrsim::Cell&) { return 0.0; });
  }
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::Dijkstra, cogrsim::GridPlanner, "dijkstra", version("1.0.0"),
                  summary("cheapest path on a grid, searched evenly in all directions"))
