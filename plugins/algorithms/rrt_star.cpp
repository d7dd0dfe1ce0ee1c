// S. Karaman, E. Frazzoli, "Sampling-based algorithms for optimal motion planning", The
// International Journal of Robotics Research 30 (2011), pp. 846-894; implementation of the Open
// Motion Planning Library (OMPL).
#include <ompl/geometric/planners/rrt/RRTstar.h>

#include "sampled_space.h"

namespace algorithms {
namespace {

/// Uses all iterations; the cost converges to the optimum with their number.
class RrtStar final : public cogrsim::SpacePlanner {
 public:
  RrtStar(const cogrsim::Parameters& parameters, std::uint64_t seed)
      : range_(std::get<double>(parameters.at("range"))),
        goal_bias_(std::get<double>(parameters.at("goal_bias"))),
        rewire_factor_(std::get<double>(parameters.at("rewire_factor"))),
        random_(seed, "rrt_star") {}

  cogrsim::Result<SpacePath> plan(const SpaceProblem& problem) override {
    return sampled_plan<ompl::geometric::RRTstar>(
        problem, random_, [&](auto& planner, double extent) {
          planner.setRange(range_ > 0.0 ? range_ : 0.2 * extent);
          planner.setGoalBias(goal_bias_);
          planner.setRewireFactor(rewire_factor_);
        });
  }

 private:
  double range_, goal_bias_, rewire_factor_;
  cogrsim::RandomStream random_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(
    algorithms::RrtStar, cogrsim::SpacePlanner, "rrt_star", version("1.0.0"),
    summary("path found by a random tree that is rewired to reduce the cost"),
    parameter("range", 0.0, "1", "longest branch, in the space's unit; 0: a fifth of its diagonal")
        .range(0.0, 1e9),
    parameter("goal_bias", 0.05, "1", "share of branches grown towards the goal").range(0.0, 1.0),
    parameter("rewire_factor", 1.1, "1",
              "factor on the number of neighbours that the theory requires")
        .range(1.0, 10.0))
