// S. M. LaValle, "Rapidly-exploring random trees: a new tool for path planning", report TR 98-11,
// Iowa State University (1998); implementation of the Open Motion Planning Library (OMPL).
#include <ompl/geometric/planners/rrt/RRT.h>

#include "sampled_space.h"

namespace algorithms {
namespace {

class Rrt final : public cogrsim::SpacePlanner {
 public:
  Rrt(const cogrsim::Parameters& parameters, std::uint64_t seed)
      : range_(std::get<double>(parameters.at("range"))),
        goal_bias_(std::get<double>(parameters.at("goal_bias"))),
        random_(seed, "rrt") {}

  cogrsim::Result<SpacePath> plan(const SpaceProblem& problem) override {
    return sampled_plan<ompl::geometric::RRT>(problem, random_, [&](auto& planner, double extent) {
      planner.setRange(range_ > 0.0 ? range_ : 0.2 * extent);
      planner.setGoalBias(goal_bias_);
    });
  }

 private:
  double range_, goal_bias_;
  cogrsim::RandomStream random_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(
    algorithms::Rrt, cogrsim::SpacePlanner, "rrt", version("1.0.0"),
    summary("first path found by a random tree, without optimisation"),
    parameter("range", 0.0, "1", "longest branch, in the space's unit; 0: a fifth of its diagonal")
        .range(0.0, 1e9),
    parameter("goal_bias", 0.05, "1", "share of branches grown towards the goal").range(0.0, 1.0))
