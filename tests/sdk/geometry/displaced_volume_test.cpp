// Volumes below a plane, against closed forms.
#include <catch2/catch.hpp>

#include <cmath>

#include "cogrsim/core/constants.h"
#include "geometry/displaced_volume.h"

using namespace cogrsim;
using geometry::Displaced;
using geometry::DisplacedShape;

namespace {

Displaced below(const Shape& shape, const Pose& X_WS, const Vec3& up, double level) {
  // Half of the pose is the shape's in the body.
  Shape placed = shape;
  placed.X_BS =
      Pose(Vec3(0.1, -0.2, 0.3), Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized())));
  return DisplacedShape(placed, {}).below(X_WS * placed.X_BS.inverse(), up, level);
}

Displaced below(const Shape& shape, const Pose& X_WS, double level) {
  return below(shape, X_WS, Vec3::UnitZ(), level);
}

Pose at(const Vec3& p, double angle = 0.0) {
  return {p, Quat(Eigen::AngleAxisd(angle, Vec3::UnitX()))};
}

// The numbers are sums of some hundred terms of the size of the result.
constexpr double kRounding = 1e-12;

}  // namespace

TEST_CASE("a sphere displaces a cap", "[displaced]") {
  Shape sphere;
  sphere.type = ShapeType::sphere;
  sphere.radius = 0.5;
  CHECK(below(sphere, at({1, 2, 3}), 2.4).volume == 0.0);
  const Displaced whole = below(sphere, at({1, 2, 3}), 3.6);
  CHECK(whole.volume == Approx(kPi / 6.0).epsilon(kRounding));
  CHECK((whole.centre - Vec3(1, 2, 3)).norm() < kRounding);
  const Displaced half = below(sphere, at({1, 2, 3}), 3.0);
  CHECK(half.volume == Approx(kPi / 12.0).epsilon(kRounding));
  CHECK((half.centre - Vec3(1, 2, 3.0 - 3.0 / 8.0 * 0.5)).norm() < kRounding);
}

TEST_CASE("a box displaces what is below the plane, upright and inclined", "[displaced]") {
  Shape box;
  box.size = Vec3(2.0, 1.0, 1.0);
  const Displaced some = below(box, at({1, 2, 3}), 2.75);
  CHECK(some.volume == Approx(0.5).epsilon(kRounding));
  CHECK((some.centre - Vec3(1, 2, 2.625)).norm() < kRounding);
  CHECK(below(box, at({1, 2, 3}), 2.4).volume == 0.0);
  // On its edge a triangle of the depth 1/sqrt(2) is below the middle.
  const Displaced half = below(box, at({1, 2, 3}, 0.25 * kPi), 3.0);
  CHECK(half.volume == Approx(1.0).epsilon(kRounding));
  CHECK((half.centre - Vec3(1, 2, 3.0 - 1.0 / (3.0 * std::sqrt(2.0)))).norm() < kRounding);
  // And one with half of this depth, a quarter of the volume, in a direction that is not z.
  const Vec3 up(0, 0, -1);
  const double level = -3.0 - 0.5 / std::sqrt(2.0);
  const Displaced quarter = below(box, at({1, 2, 3}, 0.25 * kPi), up, level);
  CHECK(quarter.volume == Approx(0.25).epsilon(kRounding));
  CHECK((quarter.centre - Vec3(1, 2, 3.0 + 2.0 / 3.0 / std::sqrt(2.0))).norm() < kRounding);
}

TEST_CASE("a cylinder is exact upright, and nearly so lying", "[displaced]") {
  Shape cylinder;
  cylinder.type = ShapeType::cylinder;
  cylinder.radius = 0.5;
  cylinder.length = 2.0;
  const Displaced some = below(cylinder, at({1, 2, 3}), 2.5);
  CHECK(some.volume == Approx(kPi * 0.25 * 0.5).epsilon(kRounding));
  CHECK((some.centre - Vec3(1, 2, 2.25)).norm() < kRounding);
  // A polygon of 64 sides differs from its circle by (2 pi / 64)^2 / 12 = 8e-4 of the radius at most.
  const double volume = kPi * 0.25 * 2.0;
  const Displaced half = below(cylinder, at({1, 2, 3}, 0.5 * kPi), 3.0);
  CHECK(half.volume == Approx(0.5 * volume).epsilon(1e-9));
  CHECK((half.centre - Vec3(1, 2, 3.0 - 4.0 * 0.5 / (3.0 * kPi))).norm() < 8e-4 * 0.5);
  // A segment of the half angle 60 degrees, depth r / 2.
  const double angle = kPi / 3.0;
  const double segment = 0.25 * (angle - std::sin(angle) * std::cos(angle)) * 2.0;
  CHECK(below(cylinder, at({1, 2, 3}, 0.5 * kPi), 2.75).volume ==
        Approx(segment).margin(1e-3 * volume));
}

TEST_CASE("a capsule lacks little of its caps, a plane displaces nothing", "[displaced]") {
  Shape capsule;
  capsule.type = ShapeType::capsule;
  capsule.radius = 0.5;
  capsule.length = 1.0;
  const double caps = kPi / 6.0, volume = kPi * 0.25 + caps;
  const Displaced whole = below(capsule, at({0, 0, 0}), 5.0);
  CHECK(whole.volume < volume);
  CHECK(whole.volume > volume - 0.0025 * caps);
  CHECK(whole.centre.norm() < 1e-12);
  CHECK(below(capsule, at({0, 0, 0}), 0.0).volume == Approx(0.5 * whole.volume).epsilon(1e-9));
  Shape plane;
  plane.type = ShapeType::plane;
  CHECK(below(plane, at({0, 0, 0}), 1.0).volume == 0.0);
}
