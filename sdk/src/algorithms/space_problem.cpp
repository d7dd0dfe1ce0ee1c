#include <cmath>
#include <exception>

#include <fmt/format.h>

#include "cogrsim/algorithms/space_planner.h"

namespace cogrsim {

namespace {

Result<> check_point(const char* what, const SpaceProblem& problem, const SpacePoint& point) {
  if (point.size() != problem.lower.size()) {
    return fail(fmt::format("the {} has {} coordinates, the space {}", what, point.size(),
                            problem.lower.size()));
  }
  for (std::size_t i = 0; i < point.size(); ++i) {
    // This form of the comparison makes NaN lie outside.
    if (point[i] >= problem.lower[i] && point[i] <= problem.upper[i]) continue;
    return fail(fmt::format("coordinate {} of the {} is {}, outside of {} to {}", i, what, point[i],
                            problem.lower[i], problem.upper[i]));
  }
  try {
    if (problem.valid(point)) return {};
  } catch (const std::exception& e) {
    return fail(fmt::format("valid() threw at the {}: {}", what, e.what()));
  } catch (...) {
    return fail(fmt::format("valid() threw at the {}", what));
  }
  return fail(fmt::format("the {} ({}) is not valid", what, fmt::join(point, ", ")));
}

}  // namespace

Result<> check_problem(const SpaceProblem& problem) {
  if (problem.lower.empty() || problem.lower.size() != problem.upper.size()) {
    return fail(
        fmt::format("the space has {} lower and {} upper bounds, but needs as many of both, "
                    "at least one",
                    problem.lower.size(), problem.upper.size()));
  }
  for (std::size_t i = 0; i < problem.lower.size(); ++i) {
    const double low = problem.lower[i], high = problem.upper[i];
    if (std::isfinite(low) && std::isfinite(high) && low < high) continue;
    return fail(
        fmt::format("coordinate {} is bounded by {} and {}; both must be finite, the lower "
                    "one first",
                    i, low, high));
  }
  if (!(problem.resolution > 0.0) || !std::isfinite(problem.resolution)) {
    return fail(fmt::format("the resolution is {}, but must be above 0", problem.resolution));
  }
  if (!(problem.goal_tolerance >= 0.0) || !std::isfinite(problem.goal_tolerance)) {
    return fail(
        fmt::format("the goal's tolerance is {}, but must be at least 0", problem.goal_tolerance));
  }
  if (problem.iterations < 1) {
    return fail(
        fmt::format("{} iterations are requested, at least 1 is needed", problem.iterations));
  }
  if (!problem.valid) return fail("the problem has no valid(), so free points are unknown");
  if (Result<> checked = check_point("start", problem, problem.start); !checked) return checked;
  return check_point("goal", problem, problem.goal);
}

}  // namespace cogrsim
