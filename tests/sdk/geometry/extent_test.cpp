// Extents, bounds and hulls against points that were tried.
#include <catch2/catch.hpp>

#include "brute_force.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/convex_hull.h"
#include "geometry/inside_shape.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::WithinAbs;

namespace {

/// Points of the shape, its frame, found by throwing darts.
std::vector<Vec3> points_inside(const SceneModel& model, const Shape& shape, RandomStream& random) {
  std::vector<Vec3> out;
  while (out.size() < 3000) {
    const Vec3 p(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
    if (geometry::inside_shape(model, shape, p)) out.push_back(p);
  }
  return out;
}

}  // namespace

TEST_CASE("extents, boxes and balls hold every point of a shape and are reached") {
  const std::string kind = GENERATE(from_range(convex_kinds()));
  CAPTURE(kind);
  RandomStream random(5, kind);
  SceneModel model;
  const Shape shape = convex_shape(kind, random, model);
  const geometry::Core core = geometry::core_of(model, shape);
  const std::vector<Vec3> points = points_inside(model, shape, random);
  const geometry::Bounds local = geometry::local_bounds(model, shape);
  const geometry::Ball ball = geometry::bounding_ball(model, shape);
  const double radius = geometry::bounding_radius(model, shape);
  double furthest = 0.0;
  for (const Vec3& p : points) {
    CHECK((p.cwiseMax(local.low).cwiseMin(local.high) - p).norm() <= 1e-12);
    CHECK((p - ball.middle).norm() <= ball.radius + 1e-12);
    furthest = std::max(furthest, p.norm());
  }
  // 3000 darts come within a few per cent of a corner.
  CHECK(furthest <= radius + 1e-12);
  CHECK(furthest >= 0.8 * radius);
  for (int i = 0; i < 50; ++i) {
    const Vec3 d = random_direction(random);
    const double extent = core.extent(d);
    CHECK_THAT(core.support(d).dot(d) + core.margin, WithinAbs(extent, 1e-12));
    double most = -kInfinity;
    for (const Vec3& p : points) most = std::max(most, p.dot(d));
    CHECK(most <= extent + 1e-12);
    CHECK(most >= 0.7 * extent);

    const Pose X = random_pose(random, 2.0);
    const Mat3 R = X.q.toRotationMatrix();
    const geometry::Bounds box = core.bounds(X);
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = R.transpose().col(k);
      CHECK_THAT(box.high[k], WithinAbs(X.p[k] + core.extent(axis), 1e-12));
      CHECK_THAT(box.low[k], WithinAbs(X.p[k] - core.extent(-axis), 1e-12));
    }
  }
}

TEST_CASE("the bounds of ground hold its samples") {
  SceneModel model;
  model.heightmaps.push_back(std::make_shared<const HeightGrid>(
      HeightGrid{"", 3, 2, 4.0, 1.0, {0.1, -0.4, 0.2, 0.3, 0.0, 0.9}}));
  Shape hill;
  hill.type = ShapeType::heightmap;
  hill.heightmap = 0;
  const geometry::Bounds box = geometry::local_bounds(model, hill);
  CHECK(box.low == Vec3(-2.0, -0.5, -0.4));
  CHECK(box.high == Vec3(2.0, 0.5, 0.9));
  CHECK(geometry::bounding_radius(model, hill) == Vec3(2.0, 0.5, 0.9).norm());
  CHECK(geometry::bounding_ball(model, hill).radius == Vec3(2.0, 0.5, 0.65).norm());

  Shape floor;
  floor.type = ShapeType::plane;
  CHECK(geometry::bounding_radius(model, floor) == kInfinity);
  CHECK(geometry::local_bounds(model, floor).high.z() == 0.0);
}

TEST_CASE("distances between convex shapes are the largest gap of all directions") {
  const std::string kind_a = GENERATE(from_range(convex_kinds()));
  const std::string kind_b = GENERATE(from_range(convex_kinds()));
  CAPTURE(kind_a, kind_b);
  RandomStream random(6, kind_a + kind_b);
  for (int i = 0; i < 6; ++i) {
    SceneModel model;
    const Shape a = convex_shape(kind_a, random, model), b = convex_shape(kind_b, random, model);
    const Pose X_a = random_pose(random, 0.5);
    Pose X_b = random_pose(random, 0.5);
    X_b.p += 2.5 * random_direction(random);
    const geometry::Core core_a = geometry::core_of(model, a), core_b = geometry::core_of(model, b);
    const double distance =
        geometry::core_distance({core_a, X_a}, {core_b, X_b}) - core_a.margin - core_b.margin;
    const double tried = -least_overlap(extent_of(model, a, X_a), extent_of(model, b, X_b));
    if (tried <= 0.0) continue;
    CHECK(distance >= tried - 1e-9);  // a gap along any direction is no more than the distance
    CHECK(distance <= tried + 2e-5);  // the search ends on a ridge of flat faces
  }
}

TEST_CASE("an edge of a flat hull has all points on its left") {
  RandomStream random(7, "hull");
  for (int round = 0; round < 40; ++round) {
    using Point = Eigen::Vector2d;
    std::vector<Point> points;
    const int count = 1 + round / 2;
    // Whole numbers: equal points and points in one line are frequent.
    for (int i = 0; i < count; ++i)
      points.emplace_back(std::floor(random.uniform(0.0, 6.0)),
                          std::floor(random.uniform(0.0, 6.0)));
    const std::vector<Point> hull = geometry::convex_hull(points);
    const auto side = [](const Point& a, const Point& b, const Point& p) {
      return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x();
    };
    REQUIRE(!hull.empty());
    for (const Point& corner : hull)
      CHECK(std::find(points.begin(), points.end(), corner) != points.end());
    for (std::size_t i = 0; i < hull.size() && hull.size() > 1; ++i) {
      const Point &a = hull[i], &b = hull[(i + 1) % hull.size()];
      for (const Point& p : points) {
        CHECK(side(a, b, p) >= 0.0);
        // In line with the edge: between its ends.
        if (side(a, b, p) == 0.0) CHECK((p - a).dot(p - b) <= 0.0);
      }
    }
  }
}
