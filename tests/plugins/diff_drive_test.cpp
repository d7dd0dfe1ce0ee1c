#include <catch2/catch.hpp>

#include <cmath>

#include "diff_drive/path_follower.h"

using namespace diff_drive;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// An ideal vehicle that follows every command, every 10 ms.
PlanarPose drive(PathFollower& follower, PlanarPose pose, double seconds, double* travelled) {
  const double dt = 0.01, track = 0.2;
  for (double t = 0; t < seconds && !follower.done(); t += dt) {
    const Velocity v = follower.update(pose);
    const WheelSpeeds w = wheel_speeds(v, 0.05, track);
    pose = rolled(pose, w.left * 0.05 * dt, w.right * 0.05 * dt, track);
    if (travelled) *travelled += std::abs(v.forward) * dt;
  }
  return pose;
}

}  // namespace

TEST_CASE("wheel speeds are those of ideal rolling") {
  // A wheel of radius 0.05 m turned at 4 rad/s rolls at 0.2 m/s.
  const auto straight = wheel_speeds({0.2, 0.0}, 0.05, 0.3);
  CHECK(straight.left == Approx(4.0));
  CHECK(straight.right == Approx(4.0));
  // On the spot, one turn a second: each wheel runs pi * track per second, in opposite directions.
  const auto spot = wheel_speeds({0.0, 2 * kPi}, 0.05, 0.3);
  CHECK(spot.right == Approx(kPi * 0.3 / 0.05));
  CHECK(spot.left == Approx(-spot.right));
}

TEST_CASE("a motor's limit slows both wheels and keeps the curvature") {
  const auto slow = limited({2.0, 8.0}, 100.0, 4.0);
  CHECK(slow.right == Approx(4.0));
  CHECK(slow.left / slow.right == Approx(0.25));
  const auto free = limited({2.0, -8.0}, 100.0, 100.0);
  CHECK(free.left == 2.0);
  CHECK(free.right == -8.0);
}

TEST_CASE("odometry of an arc equals the circle") {
  // A quarter circle to the left of radius 1 m, in one piece and in a hundred.
  const double track = 0.2, left = kPi / 2 * 0.9, right = kPi / 2 * 1.1;
  const PlanarPose once = rolled({}, left, right, track);
  CHECK(once.x == Approx(1.0).epsilon(1e-12));
  CHECK(once.y == Approx(1.0).epsilon(1e-12));
  CHECK(once.heading == Approx(kPi / 2).epsilon(1e-12));
  PlanarPose many;
  for (int i = 0; i < 100; ++i) many = rolled(many, left / 100, right / 100, track);
  CHECK(many.x == Approx(once.x).epsilon(1e-9));
  CHECK(many.y == Approx(once.y).epsilon(1e-9));
}

TEST_CASE("straight odometry has no division by zero") {
  const PlanarPose pose = rolled({1, 2, kPi / 2}, 0.5, 0.5, 0.2);
  CHECK(pose.x == Approx(1.0));
  CHECK(pose.y == Approx(2.5));
}

TEST_CASE("a square is driven and ends at its last corner") {
  FollowerSettings settings;
  PathFollower follower({{1, 0}, {1, 1}, {0, 1}, {0, 0}}, settings);
  double travelled = 0;
  const PlanarPose end = drive(follower, {}, 120, &travelled);
  REQUIRE(follower.done());
  CHECK(std::hypot(end.x, end.y) <= settings.arrival);
  // Corners are turned on the spot: the path is the square's, but for the arrival tolerances and
  // the arcs while it aligns.
  CHECK(travelled == Approx(4.0).margin(0.2));
  CHECK(follower.update(end).forward == 0.0);
  CHECK(follower.update(end).turn == 0.0);
}

TEST_CASE("a loop never ends and passes the first waypoint again") {
  FollowerSettings settings;
  settings.loop = true;
  PathFollower follower({{0.5, 0}, {0.5, 0.5}, {0, 0}}, settings);
  drive(follower, {}, 60, nullptr);
  CHECK_FALSE(follower.done());
}

TEST_CASE("a loop whose waypoints all lie within the tolerance does not hang") {
  FollowerSettings settings;
  settings.loop = true;
  PathFollower follower({{0, 0}, {0.001, 0}}, settings);
  const Velocity v = follower.update({});
  CHECK(std::isfinite(v.forward));
  CHECK(std::isfinite(v.turn));
}

TEST_CASE("a waypoint behind the vehicle makes it turn first") {
  PathFollower follower({{-1, 0.01}}, {});
  const Velocity v = follower.update({});
  CHECK(v.forward == 0.0);
  CHECK(v.turn == Approx(2.0));
}
