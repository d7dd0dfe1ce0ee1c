// Does not start.
#include <stdexcept>

#include "cogrsim/algorithms/grid_planner.h"

namespace {

class Thrower final : public cogrsim::GridPlanner {
 public:
  Thrower(const cogrsim::Parameters&, std::uint64_t) {
    throw std::runtime_error("the moon is in the wrong phase");
  }
  void set_grid(cogrsim::Grid) override {}
  const cogrsim::Grid& grid() const override { return grid_; }
  cogrsim::Result<> set_cost(const cogrsim::Cell&, double) override { return {}; }
  cogrsim::Result<> set_cost(const cogrsim::GridEdge&, double) override { return {}; }
  cogrsim::Result<cogrsim::GridPath> plan(const cogrsim::Cell&, const cogrsim::Cell&) override {
    return cogrsim::GridPath{};
  }

 private:
  cogrsim::Grid grid_;
};

}  // namespace

COGRSIM_ALGORITHM(Thrower, cogrsim::GridPlanner, "thrower", version("1.0.0"))
