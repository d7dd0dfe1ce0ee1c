// Common code of the sampling planners: a SpaceProblem for OMPL, and random numbers that depend
// only on the seed.
//
// OMPL has a generator in each object, which is seeded from a global generator at creation. Seeding
// the global generator is not sufficient in a process with other users of OMPL. Therefore every
// generator of a plan is seeded individually here: those of the planner and the sampler, and the
// one with which the nearest-neighbour tree selects its pivots.
#pragma once

#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsGNAT.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/util/Console.h>

#include <cmath>
#include <exception>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "cogrsim/algorithms/space_planner.h"
#include "cogrsim/core/random.h"

namespace algorithms {

namespace ob = ompl::base;
using cogrsim::SpacePath;
using cogrsim::SpacePoint;
using cogrsim::SpaceProblem;

/// Suppresses the messages of OMPL on standard output during its lifetime.
class Silence {
 public:
  Silence() : before_(ompl::msg::getLogLevel()) { ompl::msg::setLogLevel(ompl::msg::LOG_NONE); }
  ~Silence() { ompl::msg::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  ompl::msg::LogLevel before_;
};

inline std::uint_fast32_t short_seed(cogrsim::RandomStream& random) {
  return static_cast<std::uint_fast32_t>(random.next() >> 32);
}

class SeededSampler final : public ob::RealVectorStateSampler {
 public:
  SeededSampler(const ob::StateSpace* space, std::uint_fast32_t seed)
      : ob::RealVectorStateSampler(space) {
    rng_.setLocalSeed(seed);
  }
};

template <class Item>
class SeededTree final : public ompl::NearestNeighborsGNAT<Item> {
 public:
  explicit SeededTree(std::uint_fast32_t seed) { Pivots::seed(this->pivotSelector_, seed); }

 private:
  struct Pivots : ompl::GreedyKCenters<Item> {
    static void seed(ompl::GreedyKCenters<Item>& pivots, std::uint_fast32_t seed) {
      (pivots.*(&Pivots::rng_)).setLocalSeed(seed);
    }
  };
};

template <class Planner>
class Seeded final : public Planner {
 public:
  Seeded(const ob::SpaceInformationPtr& space, cogrsim::RandomStream& random) : Planner(space) {
    this->rng_.setLocalSeed(short_seed(random));
    this->nn_ = std::make_shared<SeededTree<typename Planner::Motion*>>(short_seed(random));
  }
};

/// The callbacks of a problem for the states of OMPL. An exception ends the plan and is reported.
class Callbacks {
 public:
  Callbacks(const SpaceProblem& problem) : problem_(problem), point_(problem.lower.size()) {}

  bool valid(const ob::State* state) {
    return guarded([&] { return problem_.valid(point_of(state)); }, false);
  }

  /// Integral of the cost along a straight line, by the trapezoidal rule.
  double cost(const ob::State* from, const ob::State* to, double length) {
    if (!problem_.cost) return length;
    const SpacePoint a = point_of(from), b = point_of(to);
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / problem_.resolution)));
    double sum = 0.0;
    for (int i = 0; i <= pieces; ++i) {
      const double share = static_cast<double>(i) / pieces;
      for (std::size_t k = 0; k < point_.size(); ++k) point_[k] = a[k] + share * (b[k] - a[k]);
      sum += (i == 0 || i == pieces ? 0.5 : 1.0) * cost_at(point_);
    }
    return sum * length / pieces;
  }

  const std::string& problem() const { return wrong_; }

  const SpacePoint& point_of(const ob::State* state) {
    const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
    point_.assign(values, values + point_.size());
    return point_;
  }

 private:
  double cost_at(const SpacePoint& point) {
    const double cost = guarded([&] { return problem_.cost(point); }, 1.0);
    if (!(cost > 0.0) || !std::isfinite(cost)) {
      wrong_ =
          fmt::format("the cost at ({}) is {}, but must be above 0", fmt::join(point, ", "), cost);
      return 1.0;
    }
    return cost;
  }

  template <class Function, class Value>
  Value guarded(Function&& function, Value otherwise) {
    if (!wrong_.empty()) return otherwise;
    try {
      return function();
    } catch (const std::exception& e) {
      wrong_ = fmt::format("a callback threw: {}", e.what());
    } catch (...) {
      wrong_ = "a callback threw something that is not a std::exception";
    }
    return otherwise;
  }

  const SpaceProblem& problem_;
  SpacePoint point_;
  std::string wrong_;
};

/// Integral of the cost of a SpaceProblem.
class IntegralObjective final : public ob::OptimizationObjective {
 public:
  IntegralObjective(const ob::SpaceInformationPtr& space, Callbacks& callbacks)
      : ob::OptimizationObjective(space), callbacks_(callbacks) {}
  ob::Cost stateCost(const ob::State*) const override { return identityCost(); }
  ob::Cost motionCost(const ob::State* a, const ob::State* b) const override {
    return ob::Cost(callbacks_.cost(a, b, si_->distance(a, b)));
  }

 private:
  Callbacks& callbacks_;
};

/// Plans with an OMPL planner; `tune(planner, space_extent)` configures it.
template <class Planner, class Tune>
cogrsim::Result<SpacePath> sampled_plan(const SpaceProblem& problem, cogrsim::RandomStream& random,
                                        Tune&& tune) {
  if (cogrsim::Result<> checked = cogrsim::check_problem(problem); !checked) {
    return tl::unexpected(checked.error());
  }
  const Silence silence;
  const auto dimensions = static_cast<unsigned>(problem.lower.size());
  const auto space = std::make_shared<ob::RealVectorStateSpace>(dimensions);
  ob::RealVectorBounds bounds(dimensions);
  bounds.low = problem.lower;
  bounds.high = problem.upper;
  space->setBounds(bounds);
  space->setStateSamplerAllocator([seed = short_seed(random)](const ob::StateSpace* of) {
    return std::make_shared<SeededSampler>(of, seed);
  });
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  Callbacks callbacks(problem);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return callbacks.valid(state); });
  const double extent = space->getMaximumExtent();
  information->setStateValidityCheckingResolution(std::min(1.0, problem.resolution / extent));
  information->setup();

  ob::ScopedState<> start(space), goal(space);
  for (unsigned i = 0; i < dimensions; ++i) {
    start[i] = problem.start[i];
    goal[i] = problem.goal[i];
  }
  const auto definition = std::make_shared<ob::ProblemDefinition>(information);
  // In OMPL a state within the threshold is at the goal.
  definition->setStartAndGoalStates(start, goal, std::nextafter(problem.goal_tolerance, extent));
  if (problem.cost) {
    definition->setOptimizationObjective(
        std::make_shared<IntegralObjective>(information, callbacks));
  } else {
    definition->setOptimizationObjective(
        std::make_shared<ob::PathLengthOptimizationObjective>(information));
  }
  Seeded<Planner> planner(information, random);
  planner.setProblemDefinition(definition);
  tune(planner, extent);
  planner.setup();

  SpacePath path;
  const ob::PlannerTerminationCondition enough([&] {
    if (!callbacks.problem().empty() || path.iterations >= problem.iterations) return true;
    ++path.iterations;
    return false;
  });
  const ob::PlannerStatus status = planner.solve(enough);
  if (!callbacks.problem().empty()) return cogrsim::fail(callbacks.problem());
  if (status != ob::PlannerStatus::EXACT_SOLUTION) {
    return cogrsim::fail(fmt::format("no path from ({}) to ({}) was found with {} iterations",
                                     fmt::join(problem.start, ", "), fmt::join(problem.goal, ", "),
                                     problem.iterations),
                         "", "there may be none, or more iterations find it",
                         cogrsim::kNoPathFound);
  }
  const auto& found = *definition->getSolutionPath()->template as<ompl::geometric::PathGeometric>();
  for (std::size_t i = 0; i < found.getStateCount(); ++i) {
    const ob::State* state = found.getState(static_cast<unsigned>(i));
    path.points.push_back(callbacks.point_of(state));
    if (i == 0) continue;
    const ob::State* before = found.getState(static_cast<unsigned>(i - 1));
    const double length = space->distance(before, state);
    path.length += length;
    path.cost += callbacks.cost(before, state, length);
  }
  if (!callbacks.problem().empty()) return cogrsim::fail(callbacks.problem());
  return path;
}

}  // namespace algorithms
