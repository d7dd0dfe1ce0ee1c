// Planners in continuous spaces: "rrt", "rrt_star", and yours.
#pragma once

#include <functional>
#include <vector>

#include "cogrsim/algorithms/algorithm.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// A point of the space, (n): a place in the plane or in space [m], or the angles of an arm [rad].
using SpacePoint = std::vector<double>;

/// What to plan. The space is a box of R^n with the Euclidean distance: an angle does not wrap, so
/// bound it to one turn.
struct SpaceProblem {
  SpacePoint lower, upper;       ///< corners of the box, (n) each, lower < upper
  SpacePoint start, goal;        ///< (n), inside of the box
  double goal_tolerance = 1e-6;  ///< the path ends this near to the goal, >= 0
  /// Whether a point is free. Asked for points at most `resolution` apart along the path: something
  /// thinner than that may be missed.
  std::function<bool(const SpacePoint&)> valid;
  /// What a unit of length costs at a point, > 0; empty: 1 everywhere, the path's length counts.
  std::function<double(const SpacePoint&)> cost;
  double resolution = 0.01;  ///< > 0
  /// How long to try: points to sample, > 0. Not seconds, so that a plan is the same on a slow
  /// machine.
  int iterations = 5000;
};

struct SpacePath {
  std::vector<SpacePoint> points;  ///< from start to goal, (n) each; straight lines between them
  double cost = 0.0;    ///< integral of the cost along it, by the trapezoidal rule at `resolution`
  double length = 0.0;  ///< of the path
  int iterations = 0;   ///< points sampled
};

/// Finds a way among obstacles. The n-th call on a new planner gives the same path whenever seed,
/// parameters and problems are the same.
class SpacePlanner {
 public:
  static constexpr const char* kFamily = "space-planner";
  virtual ~SpacePlanner() = default;

  /// Errors: sizes that do not fit, bounds or points that are not finite or outside, start or goal
  /// not valid, no callback, a callback that threw or a cost that is not above 0, no way found
  /// within the iterations (code kNoWayFound: there may be one).
  virtual Result<SpacePath> plan(const SpaceProblem& problem) = 0;
};

/// Error::code of a plan that ran out of iterations.
inline constexpr const char* kNoWayFound = "no-way-found";

/// The errors in a problem that every planner reports alike; empty: none. Asks valid() for start
/// and goal.
COGRSIM_API Result<> check_problem(const SpaceProblem& problem);

}  // namespace cogrsim
