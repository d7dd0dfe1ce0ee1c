// Separating axes of boxes and clipped faces against directions and points that were tried.
#include "cogrsim/geometry/manifold.h"

#include <catch2/catch.hpp>

#include "brute_force.h"
#include "cogrsim/core/constants.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::WithinAbs;

TEST_CASE("the separation of two boxes is the least overlap of all directions") {
  RandomStream random(8, "boxes");
  int touching = 0, parted = 0;
  for (int i = 0; i < 60; ++i) {
    SceneModel model;
    const Shape a = convex_shape("box", random, model), b = convex_shape("box", random, model);
    const Pose X_a = random_pose(random, 0.5), X_b = random_pose(random, 0.8);
    const Extent extent_a = extent_of(model, a, X_a), extent_b = extent_of(model, b, X_b);
    const double least = least_overlap(extent_a, extent_b);
    const Vec3 half_a = 0.5 * a.size, half_b = 0.5 * b.size;
    const geometry::Placement A(X_a), B(X_b);
    const geometry::Separation found = geometry::separate_boxes({half_a, A}, {half_b, B}, 0.0);
    // Between corners of parted boxes no axis of the fifteen is the direction of the gap.
    if (!found.found) {
      CHECK(least <= 2e-5);
      ++parted;
      continue;
    }
    ++touching;
    CHECK_THAT(found.normal.norm(), WithinAbs(1.0, 1e-12));
    CHECK_THAT(overlap_along(extent_a, extent_b, found.normal), WithinAbs(-found.gap, 1e-12));
    CHECK(-found.gap >= least - 2e-5);          // the search ends on a ridge
    CHECK(-found.gap <= 1.021 * least + 2e-6);  // faces are preferred by 2 % and 1e-6 m
    if (!found.has_points) continue;
    CHECK_THAT((found.on_b - found.on_a - found.gap * found.normal).norm(), WithinAbs(0.0, 1e-9));
  }
  CHECK(touching > 15);
  CHECK(parted > 5);
}

TEST_CASE("contact points between two faces span what the faces have in common") {
  RandomStream random(9, "faces");
  constexpr double kPitch = 0.02;
  int met = 0;
  for (int round = 0; round < 30; ++round) {
    // Two rectangles in horizontal planes, the second 1 mm above the first.
    struct Rectangle {
      Eigen::Vector2d middle, half;
      double turn;
      bool holds(const Eigen::Vector2d& p) const {
        const Eigen::Vector2d local = Eigen::Rotation2Dd(-turn) * (p - middle);
        return (local.cwiseAbs() - half).maxCoeff() <= 1e-9;
      }
    };
    std::array<Rectangle, 2> faces;
    geometry::Feature features[2];
    for (std::size_t k = 0; k < 2; ++k) {
      Rectangle& f = faces[k];
      f.middle = {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)};
      f.half = {random.uniform(0.2, 0.7), random.uniform(0.2, 0.7)};
      f.turn = random.uniform(-kPi, kPi);
      for (int c = 0; c < 4; ++c) {
        const Eigen::Vector2d corner(c == 1 || c == 2 ? f.half.x() : -f.half.x(),
                                     c >= 2 ? f.half.y() : -f.half.y());
        const Eigen::Vector2d p = f.middle + Eigen::Rotation2Dd(f.turn) * corner;
        features[k].add({p.x(), p.y(), 1e-3 * static_cast<double>(k)});
      }
    }
    geometry::Separation separation;
    separation.found = true;
    separation.gap = 1e-3;
    std::vector<geometry::ContactPoint> points;
    geometry::face_contacts(features[0], features[1], separation, 0.01, points);
    for (const geometry::ContactPoint& point : points) {
      CHECK_THAT(point.gap, WithinAbs(1e-3, 1e-12));
      CHECK_THAT(point.point.z(), WithinAbs(0.5e-3, 1e-12));
      for (const Rectangle& f : faces) CHECK(f.holds(point.point.head<2>()));
    }
    for (int i = 0; i < 16; ++i) {
      const Eigen::Vector2d d(std::cos(0.125 * kPi * i), std::sin(0.125 * kPi * i));
      double most = -kInfinity, tried = -kInfinity;
      for (const geometry::ContactPoint& point : points)
        most = std::max(most, point.point.head<2>().dot(d));
      for (double x = -1.5; x < 1.5; x += kPitch)
        for (double y = -1.5; y < 1.5; y += kPitch)
          if (const Eigen::Vector2d p(x, y); faces[0].holds(p) && faces[1].holds(p))
            tried = std::max(tried, p.dot(d));
      if (tried == -kInfinity) continue;
      ++met;
      CHECK(tried <= most + 1e-9);
      // A sharp corner may lie between the points of the grid.
      CHECK(tried >= most - 8.0 * kPitch);
    }

    std::vector<geometry::ContactPoint> few = points;
    geometry::reduce_points(few, 0);
    CHECK(few.size() == std::min<std::size_t>(points.size(), 4));
  }
  CHECK(met > 200);
}

// The outline of two squares that nearly coincide has eight corners: four that bear, and where edges
// cross, anywhere along them.
TEST_CASE("faces that nearly coincide keep their corners") {
  RandomStream random(11, "coincident faces");
  constexpr double kHalf = 0.1, kOff = 1e-7;
  int crossed = 0;
  for (int round = 0; round < 1000; ++round) {
    geometry::Feature features[2];
    for (int k = 0; k < 2; ++k) {
      const Eigen::Rotation2Dd turn(k * random.uniform(-kOff, kOff));
      const Eigen::Vector2d shift(k * random.uniform(-kOff, kOff), k * random.uniform(-kOff, kOff));
      for (int c = 0; c < 4; ++c) {
        const Eigen::Vector2d corner(c == 1 || c == 2 ? kHalf : -kHalf, c >= 2 ? kHalf : -kHalf);
        const Eigen::Vector2d p = shift + turn * corner;
        features[k].add({p.x(), p.y(), 0.0});
      }
    }
    geometry::Separation separation;
    separation.found = true;
    std::vector<geometry::ContactPoint> points;
    geometry::face_contacts(features[0], features[1], separation, 0.01, points);
    crossed += points.size() > 4;
    geometry::reduce_points(points, 0);
    REQUIRE(points.size() == 4);
    double sum_x = 0.0, sum_y = 0.0;
    for (const geometry::ContactPoint& point : points) {
      CHECK_THAT(std::abs(point.point.x()), WithinAbs(kHalf, 4.0 * kOff));
      CHECK_THAT(std::abs(point.point.y()), WithinAbs(kHalf, 4.0 * kOff));
      sum_x += point.point.x();
      sum_y += point.point.y();
    }
    CHECK_THAT(sum_x, WithinAbs(0.0, 16.0 * kOff));  // one of each
    CHECK_THAT(sum_y, WithinAbs(0.0, 16.0 * kOff));
  }
  CHECK(crossed > 50);
}
