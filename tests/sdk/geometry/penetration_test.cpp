// Penetration depths of convex shapes, against brute-force directions and closed forms.
#include <catch2/catch.hpp>

#include "brute_force.h"
#include "cogrsim/model/builder.h"

using namespace cogrsim;
using namespace cogrsim::test;
using geometry::Penetration;
using geometry::penetration;

namespace {

// What overlap.h promises: 1e-4 of the depth and 1e-10 of the size; shapes here are below 4 m.
constexpr double kRelative = 1e-4, kAbsolute = 1e-9;

Shape box(double x, double y, double z) {
  Shape shape;
  shape.size = {x, y, z};
  return shape;
}

Shape round(ShapeType type, double radius, double length = 0.0) {
  Shape shape;
  shape.type = type;
  shape.radius = radius;
  shape.length = length;
  return shape;
}

double depth(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return penetration(SceneModel(), a, X_WA, b, X_WB).depth;
}

/// Two shapes keep their penetration depth at any pose of the pair.
void check_everywhere(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      double expected, double tolerance) {
  RandomStream random(1, "everywhere");
  for (int i = 0; i < 20; ++i) {
    const Pose X = i == 0 ? Pose() : random_pose(random, 5.0);
    CHECK(depth(a, X * X_WA, b, X * X_WB) == Approx(expected).margin(tolerance));
    CHECK(depth(b, X * X_WB, a, X * X_WA) == Approx(expected).margin(tolerance));
  }
}

}  // namespace

TEST_CASE("the depth of every pair of convex kinds is the least overlap of all directions") {
  int deep = 0, separated = 0;
  for (std::size_t i = 0; i < convex_kinds().size(); ++i)
    for (std::size_t j = i; j < convex_kinds().size(); ++j) {
      RandomStream random(7, convex_kinds()[i] + convex_kinds()[j]);
      INFO(convex_kinds()[i] << " and " << convex_kinds()[j]);
      for (int trial = 0; trial < 24; ++trial) {
        SceneModel model;
        const Shape a = convex_shape(convex_kinds()[i], random, model);
        const Shape b = convex_shape(convex_kinds()[j], random, model);
        // From one inside the other to separated.
        const Pose X_WA = random_pose(random, 3.0);
        const Pose X_AB = random_pose(random, 0.1 + 0.05 * trial);
        const Pose X_WB = X_WA * X_AB;
        const Extent A = extent_of(model, a, X_WA), B = extent_of(model, b, X_WB);
        const Penetration in = penetration(model, a, X_WA, b, X_WB);
        const double tried = least_overlap(A, B);
        INFO("trial " << trial << ": " << in.depth << " m, tried " << tried << " m");
        REQUIRE(in.normal.norm() == Approx(1.0));
        if (in.depth <= 0.0) {
          CHECK(tried <= kAbsolute);
          ++separated;
          continue;
        }
        // The given separation separates them, and there is none shorter.
        CHECK(overlap_along(A, B, in.normal) == Approx(in.depth).epsilon(1e-6).margin(kAbsolute));
        CHECK(in.depth <= tried * (1.0 + kRelative) + kAbsolute);
        CHECK(tried > 0.0);
        const Penetration back = penetration(model, b, X_WB, a, X_WA);
        CHECK(back.depth == Approx(in.depth).epsilon(2 * kRelative).margin(2 * kAbsolute));
        ++deep;
      }
    }
  CHECK(deep > 150);
  CHECK(separated > 50);
}

TEST_CASE("shapes in regular configurations have the depth of the closed form") {
  const Pose here;
  const Pose beside({0.3, 0.0, 0.0}, Quat(1, 0, 0, 0));
  const Quat quarter(Eigen::AngleAxisd(1.5707963267948966, Vec3::UnitX()));
  // The same position: out through the nearest side.
  check_everywhere(box(1, 2, 3), here, box(1, 2, 3), here, 1.0, kAbsolute);
  check_everywhere(box(1, 2, 3), here, box(0.1, 0.1, 0.1), here, 0.55, kAbsolute);
  check_everywhere(box(1, 1, 1), here, box(1, 1, 1), beside, 0.7, kAbsolute);
  check_everywhere(box(1, 1, 1), here, round(ShapeType::sphere, 0.25), here, 0.75, kAbsolute);
  const Shape ball = round(ShapeType::sphere, 0.5);
  check_everywhere(ball, here, ball, here, 1.0, kAbsolute);
  check_everywhere(ball, here, ball, beside, 0.7, kAbsolute);
  // Capsules crossing each other, in line, one in the other.
  const Shape pill = round(ShapeType::capsule, 0.2, 1.0);
  check_everywhere(pill, here, pill, Pose({0, 0, 0}, quarter), 0.4, kAbsolute);
  check_everywhere(pill, here, pill, Pose({0, 0, 1.3}, Quat(1, 0, 0, 0)), 0.1, kAbsolute);
  check_everywhere(pill, here, pill, here, 0.4, kAbsolute);
  check_everywhere(pill, here, pill, Pose({0.1, 0, 0.4}, Quat(1, 0, 0, 0)), 0.3, kAbsolute);
  // Cylinders with one axis: sideways the separation is the same all around.
  const Shape log = round(ShapeType::cylinder, 0.3, 2.0);
  check_everywhere(log, here, round(ShapeType::cylinder, 0.1, 2.0), here, 0.4, 0.4 * kRelative);
  check_everywhere(log, here, log, Pose({0, 0, 1.9}, Quat(1, 0, 0, 0)), 0.1, 1e-8);
  check_everywhere(log, here, log, Pose({0, 0.5, 0}, Quat(1, 0, 0, 0)), 0.1, 0.1 * kRelative);
  check_everywhere(log, here, ball, Pose({0.7, 0, 0}, Quat(1, 0, 0, 0)), 0.1, kAbsolute);
  check_everywhere(log, here, pill, here, 0.5, 0.5 * kRelative);
}

TEST_CASE("exact contact has no penetration") {
  const Quat straight(1, 0, 0, 0);
  const Quat eighth(Eigen::AngleAxisd(0.7853981633974483, Vec3::UnitX()));
  const Pose here;
  const double edge = std::sqrt(2.0) / 2.0;
  const Shape cube = box(1, 1, 1), ball = round(ShapeType::sphere, 0.5);
  const Shape can = round(ShapeType::cylinder, 0.5, 1.0),
              pill = round(ShapeType::capsule, 0.2, 1.0);
  // Far below kTouchingDepth: rounding at 10 m.
  constexpr double kNothing = 1e-8;
  for (const Vec3& side : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0.4, 0.3)})
    check_everywhere(cube, here, cube, Pose(side, straight), 0.0, kNothing);
  check_everywhere(cube, here, cube, Pose({0, 0, 0.5 + edge}, eighth), 0.0, kNothing);
  check_everywhere(cube, Pose({0, 0, 0}, eighth), cube, Pose({0, 0, 2 * edge}, eighth), 0.0,
                   kNothing);
  check_everywhere(cube, here, ball, Pose({0.2, 0.1, 1.0}, straight), 0.0, kNothing);
  check_everywhere(cube, here, can, Pose({0.2, 0.1, 1.0}, straight), 0.0, kNothing);
  check_everywhere(can, here, can, Pose({0.0, 0.0, 1.0}, straight), 0.0, kNothing);
  check_everywhere(can, here, can, Pose({0.6, 0.8, 0.0}, straight), 0.0, kNothing);
  check_everywhere(pill, here, cube, Pose({0.7, 0.0, 0.3}, straight), 0.0, kNothing);
  check_everywhere(pill, here, pill, Pose({0.0, 0.0, 1.4}, straight), 0.0, kNothing);
  check_everywhere(ball, here, ball, Pose({0.6, 0.8, 0.0}, straight), 0.0, kNothing);
}
