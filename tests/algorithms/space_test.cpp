// Planners that sample a space: they find paths, repeat them, and the optimising one gets near to
// the known shortest path.
#include <cmath>
#include <limits>
#include <stdexcept>

#include "cogrsim/algorithms/space_planner.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const double kPi = std::acos(-1.0);

SpaceProblem unit_square() {
  SpaceProblem problem;
  problem.lower = {0.0, 0.0};
  problem.upper = {1.0, 1.0};
  problem.start = {0.1, 0.5};
  problem.goal = {0.9, 0.5};
  problem.valid = [](const SpacePoint&) { return true; };
  return problem;
}

double distance(const SpacePoint& a, const SpacePoint& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

/// Its ends are right, and its length is that of its pieces.
void check_path(const SpaceProblem& problem, const SpacePath& path) {
  REQUIRE(path.points.size() >= 2);
  CHECK(path.points.front() == problem.start);
  CHECK(distance(path.points.back(), problem.goal) <= problem.goal_tolerance);
  double length = 0.0;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    length += distance(path.points[i - 1], path.points[i]);
  }
  CHECK(length == Approx(path.length));
  CHECK(path.iterations <= problem.iterations);
}

/// Shortest path between two points on opposite sides, D from the centre of a disc of radius R:
/// two tangents and the arc between.
double around(double D, double R) {
  return 2.0 * std::sqrt(D * D - R * R) + R * (kPi - 2.0 * std::acos(R / D));
}

}  // namespace

TEST_CASE("sampling planners find a path through a gap", "[algorithms][space]") {
  const std::string name = GENERATE(values<std::string>({"rrt", "rrt_star"}));
  const auto seed = GENERATE(1u, 2u, 3u);
  SpaceProblem problem = unit_square();
  // A wall across, open for a tenth of its length.
  const auto in_wall = [](const SpacePoint& p, double less) {
    return p[0] > 0.45 + less && p[0] < 0.55 - less && (p[1] < 0.7 - less || p[1] > 0.8 + less);
  };
  problem.valid = [&](const SpacePoint& p) { return !in_wall(p, 0.0); };
  const auto path = make<SpacePlanner>(name, {}, seed)->plan(problem);
  if (!path) FAIL(path.error().text());
  check_path(problem, *path);
  // The straight path to the gap's nearest corners and back.
  const double shortest = std::hypot(0.35, 0.2) + 0.1 + std::hypot(0.35, 0.2);
  CHECK(path->length > shortest - 2.0 * problem.resolution);
  for (std::size_t i = 1; i < path->points.size(); ++i) {
    const SpacePoint &a = path->points[i - 1], &b = path->points[i];
    for (int k = 0; k <= 200; ++k) {
      const double s = k / 200.0;
      // Between two checked points, `resolution` apart, a corner may be cut that deep.
      CHECK_FALSE(
          in_wall({a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])}, problem.resolution));
    }
  }
}

TEST_CASE("the seed alone decides a sampled path", "[algorithms][space]") {
  const std::string name = GENERATE(values<std::string>({"rrt", "rrt_star"}));
  SpaceProblem problem = unit_square();
  problem.iterations = 1500;
  problem.valid = [](const SpacePoint& p) { return std::hypot(p[0] - 0.5, p[1] - 0.5) > 0.2; };
  const auto plans = [&](std::uint64_t seed) {
    auto planner = make<SpacePlanner>(name, {}, seed);
    std::vector<SpacePath> out;
    for (int i = 0; i < 3; ++i) {
      auto path = planner->plan(problem);
      REQUIRE(path);
      out.push_back(std::move(*path));
    }
    return out;
  };
  const auto first = plans(5);
  // Other random streams in the same process change nothing.
  auto other = make<SpacePlanner>(name == "rrt" ? "rrt_star" : "rrt", {}, 77);
  REQUIRE(other->plan(problem));
  const auto second = plans(5), different = plans(6);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(first[i].points == second[i].points);
    CHECK(first[i].cost == second[i].cost);
    CHECK(first[i].points != different[i].points);
  }
  CHECK(first[0].points != first[1].points);  // the stream continues
}

TEST_CASE("RRT* approaches the shortest path around a disc", "[algorithms][space]") {
  const double D = 0.4, R = 0.2, resolution = 0.005;
  const auto seed = GENERATE(1u, 2u, 3u);
  SpaceProblem problem = unit_square();
  problem.resolution = resolution;
  problem.valid = [&](const SpacePoint& p) { return std::hypot(p[0] - 0.5, p[1] - 0.5) > R; };
  double before = std::numeric_limits<double>::infinity();
  for (const int iterations : {500, 2000, 8000}) {
    problem.iterations = iterations;
    const auto path = make<SpacePlanner>("rrt_star", {}, seed)->plan(problem);
    REQUIRE(path);
    check_path(problem, *path);
    CHECK(path->cost == Approx(path->length));
    // The same seed grows the same tree for longer, and a tree only ever gets better.
    CHECK(path->cost <= before);
    before = path->cost;
    CHECK(path->iterations == iterations);
  }
  // From below: a chord between points `resolution` apart dips into the disc by at most its sagitta.
  CHECK(before >= around(D, R - resolution * resolution / (8.0 * R)) - 1e-12);
  // From above: n points leave no empty disc larger than about h = sqrt(ln n / (pi n)) = 0.019. A
  // tree whose nodes are that far off the best path, in hops of the k-nearest radius r =
  // sqrt(k / (pi n)), k = 1.1 e (1 + 1/2) ln n, r = 0.041, is longer by (h/r)^2 / 2 = 11 % if every
  // node were at its worst, on alternating sides. Offsets spread evenly over the disc have a mean
  // square of h^2/4 per axis, so that the expected excess is a quarter of it: 2.7 %.
  CHECK(before <= 1.027 * around(D, R));
}

TEST_CASE("RRT* weighs the cost of a position", "[algorithms][space]") {
  SpaceProblem problem = unit_square();
  problem.iterations = 4000;
  // The disc may be crossed, at ten times the cost: the path around costs 0.90, the straight one
  // 4.4.
  problem.cost = [](const SpacePoint& p) {
    return std::hypot(p[0] - 0.5, p[1] - 0.5) < 0.2 ? 10.0 : 1.0;
  };
  const auto path = make<SpacePlanner>("rrt_star", {}, 4)->plan(problem);
  REQUIRE(path);
  check_path(problem, *path);
  // The trapezoidal rule sees the disc's rim to within a resolution, at each of two crossings.
  CHECK(path->cost >= around(0.4, 0.2) - 2.0 * 9.0 * problem.resolution);
  // Half of the points of the test above: twice the excess.
  CHECK(path->cost <= 1.054 * around(0.4, 0.2));
  problem.cost = [](const SpacePoint&) { return 3.0; };
  const auto tripled = make<SpacePlanner>("rrt", {}, 4)->plan(problem);
  REQUIRE(tripled);
  CHECK(tripled->cost == Approx(3.0 * tripled->length));
}

TEST_CASE("sampling planners work in more dimensions", "[algorithms][space]") {
  const std::string name = GENERATE(values<std::string>({"rrt", "rrt_star"}));
  for (const std::size_t n : {1u, 3u, 6u}) {
    SpaceProblem problem;
    problem.lower = SpacePoint(n, -1.0);
    problem.upper = SpacePoint(n, 1.0);
    problem.start = SpacePoint(n, -0.7);
    problem.goal = SpacePoint(n, 0.7);
    problem.resolution = 0.05;
    problem.iterations = 2000;
    problem.valid = [&](const SpacePoint& p) {
      return n == 1 || distance(p, SpacePoint(n, 0.0)) > 0.3;
    };
    const auto path = make<SpacePlanner>(name, {}, 3)->plan(problem);
    if (!path) FAIL(path.error().text());
    check_path(problem, *path);
    CHECK(path->length >= 1.4 * std::sqrt(static_cast<double>(n)) - 1e-9);
  }
}

TEST_CASE("sampling planners report their errors", "[algorithms][space]") {
  const std::string name = GENERATE(values<std::string>({"rrt", "rrt_star"}));
  auto planner = make<SpacePlanner>(name);
  const double nan = std::nan("");
  const auto complaint = [&](auto&& change) {
    SpaceProblem problem = unit_square();
    problem.iterations = 300;
    change(problem);
    return said(planner->plan(problem));
  };
  CHECK(complaint([](SpaceProblem&) {}).empty());
  CHECK(has(complaint([](SpaceProblem& p) { p.lower.clear(); }), "0 lower and 2 upper bounds"));
  CHECK(has(complaint([](SpaceProblem& p) { p.upper[1] = 0.0; }),
            "coordinate 1 is bounded by 0 and 0"));
  CHECK(
      has(complaint([&](SpaceProblem& p) { p.lower[0] = nan; }), "coordinate 0 is bounded by nan"));
  CHECK(has(complaint([&](SpaceProblem& p) { p.start[0] = nan; }), "of the start is nan"));
  CHECK(
      has(complaint([](SpaceProblem& p) { p.goal[1] = 1.5; }), "coordinate 1 of the goal is 1.5"));
  CHECK(has(complaint([](SpaceProblem& p) { p.goal = {0.5}; }),
            "the goal has 1 coordinates, the space 2"));
  CHECK(has(complaint([](SpaceProblem& p) { p.valid = nullptr; }), "no valid()"));
  CHECK(has(complaint([](SpaceProblem& p) { p.iterations = 0; }), "0 iterations"));
  CHECK(has(complaint([](SpaceProblem& p) { p.resolution = 0.0; }), "the resolution is 0"));
  CHECK(has(complaint([](SpaceProblem& p) { p.goal_tolerance = -1.0; }), "tolerance is -1"));
  CHECK(has(complaint([](SpaceProblem& p) {
              p.valid = [](const SpacePoint& at) { return at[0] < 0.5; };
            }),
            "the goal (0.9, 0.5) is not valid"));
  CHECK(has(complaint([](SpaceProblem& p) {
              p.valid = [](const SpacePoint& at) -> bool {
                if (at[0] > 0.2 && at[0] < 0.8) throw std::runtime_error("the map is gone");
                return true;
              };
            }),
            "a callback threw: the map is gone"));
  CHECK(has(complaint([](SpaceProblem& p) { p.cost = [](const SpacePoint&) { return -1.0; }; }),
            "is -1, but must be above 0"));
  SpaceProblem closed = unit_square();
  closed.iterations = 300;
  closed.valid = [](const SpacePoint& p) { return std::abs(p[0] - 0.5) > 0.1; };
  const auto none = planner->plan(closed);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == kNoPathFound);
  CHECK(has(none.error().message, "300 iterations"));
}
