// The interface of planners in continuous spaces, such as "rrt" and "rrt_star".
#pragma once

#include <functional>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// A point of the space (n), for example a position [m] or the joint angles of an arm [rad].
using SpacePoint = std::vector<double>;

/// A planning problem. The space is a box in R^n with the Euclidean distance. Angles do not wrap,
/// so limit them to one turn.
struct SpaceProblem {
  SpacePoint lower, upper;       ///< corners of the box, (n) each, lower < upper
  SpacePoint start, goal;        ///< (n), inside of the box
  double goal_tolerance = 1e-6;  ///< largest distance of the end of the path from the goal, >= 0
  /// Whether a point is free. Called for points at most `resolution` apart along the path, so that
  /// thinner obstacles may be missed.
  std::function<bool(const SpacePoint&)> valid;
  /// Cost per unit of length at a point, > 0; empty: 1, so that the cost is the length of the path.
  std::function<double(const SpacePoint&)> cost;
  double resolution = 0.01;  ///< distance between checked points along a path, > 0
  /// Number of points to sample, > 0. It is not a time, so that a plan does not depend on the speed
  /// of the machine.
  int iterations = 5000;
};

/// A path in a continuous space.
struct SpacePath {
  std::vector<SpacePoint> points;  ///< from start to goal, (n) each; straight lines between them
  double cost = 0.0;    ///< integral of the cost along the path (trapezoidal rule at `resolution`)
  double length = 0.0;  ///< length of the path
  int iterations = 0;   ///< number of sampled points
};

/// Finds paths among obstacles. The n-th call on a new planner gives the same path if the seed, the
/// parameters and the problems are the same.
class SpacePlanner {
 public:
  static constexpr const char* kFamily = "space-planner";
  virtual ~SpacePlanner() = default;

  /// Plans a path. Errors: the sizes of vectors differ; bounds or points are not finite or outside
  /// of the box; start or goal is not valid; `valid` is empty; a callback throws; a cost is not
  /// above 0; no path was found within the iterations (code kNoPathFound), although one may exist.
  virtual Result<SpacePath> plan(const SpaceProblem& problem) = 0;
};

/// Error::code if no path was found within the iterations.
inline constexpr const char* kNoPathFound = "no-path-found";

/// Checks a problem for the errors that all planners report in the same way. Calls valid() for
/// start and goal.
COGRSIM_API Result<> check_problem(const SpaceProblem& problem);

}  // namespace cogrsim
