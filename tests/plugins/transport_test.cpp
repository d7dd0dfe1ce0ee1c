// What the transport experiment's robots make of what they see; that they bring their boxes is shown
// by the example.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "box_carrier/sightings.h"
#include "box_carrier/traffic.h"

using namespace box_carrier;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSide = 0.12;
const Rectangle kArena{-2.0, 2.0, -1.5, 1.5};

/// Distance along a ray from `eye` to a segment; infinite: it passes.
double to_segment(const PlanarPoint& eye, double direction, const PlanarPoint& a,
                  const PlanarPoint& b) {
  const double dx = std::cos(direction), dy = std::sin(direction);
  const double ex = b.x - a.x, ey = b.y - a.y, cross = dx * ey - dy * ex;
  if (std::abs(cross) < 1e-12) return std::numeric_limits<double>::infinity();
  const double t = ((a.x - eye.x) * ey - (a.y - eye.y) * ex) / cross;
  const double s = ((a.x - eye.x) * dy - (a.y - eye.y) * dx) / cross;
  return t > 0.0 && s >= 0.0 && s <= 1.0 ? t : std::numeric_limits<double>::infinity();
}

std::vector<PlanarPoint> corners(const Box& box) {
  std::vector<PlanarPoint> out;
  for (int k = 0; k < 4; ++k) {
    const double a = box.yaw + kPi / 4 + k * kPi / 2, r = kSide / std::sqrt(2.0);
    out.push_back({box.centre.x + r * std::cos(a), box.centre.y + r * std::sin(a)});
  }
  return out;
}

/// The scan of a range finder with 360 exact rays among boxes in the arena.
Scan look_from(const PlanarPose& eye, const std::vector<Box>& boxes) {
  std::vector<std::vector<PlanarPoint>> outlines;
  outlines.push_back({{kArena.west, kArena.south},
                      {kArena.east, kArena.south},
                      {kArena.east, kArena.north},
                      {kArena.west, kArena.north}});
  for (const Box& box : boxes) outlines.push_back(corners(box));
  Scan scan;
  scan.sensor = eye;
  for (int i = 0; i < 360; ++i) {
    scan.bearings.push_back(-kPi + i * kPi / 180);
    double least = std::numeric_limits<double>::infinity();
    for (const auto& outline : outlines) {
      for (std::size_t k = 0; k < 4; ++k) {
        least = std::min(least, to_segment(position_of(eye), eye.heading + scan.bearings.back(),
                                           outline[k], outline[(k + 1) % 4]));
      }
    }
    scan.ranges.push_back(least);
  }
  return scan;
}

/// Angle between two boxes' sides: a square looks the same after a quarter turn.
double turned(double a, double b) { return std::abs(std::remainder(a - b, kPi / 2)); }

/// Drives straight on whenever it may.
struct Walker {
  PlanarPose pose;
  double speed = 0.35, radius = 0.27;
  TrafficRules rules;
  Neighbour other;
};

}  // namespace

TEST_CASE("a box is found with its position and heading", "[transport]") {
  const double yaw = GENERATE(0.0, 0.3, 0.7, 1.1, 1.5);
  const double range = GENERATE(0.3, 0.5, 0.8);
  const double bearing = GENERATE(-3.1, -1.2, 0.4, 2.0);
  const PlanarPose eye{0.2, -0.1, 0.6};
  Box truth;
  truth.centre = {eye.x + range * std::cos(bearing), eye.y + range * std::sin(bearing)};
  truth.yaw = yaw;
  const auto clusters = clusters_of(look_from(eye, {truth}), kArena, 0.05, 0.07);
  // A face seen at a slant may fall off; it is then known to be hidden.
  const auto whole = std::find_if(clusters.begin(), clusters.end(),
                                  [](const Cluster& cluster) { return !cluster.hidden; });
  REQUIRE(whole != clusters.end());
  CHECK(std::count_if(clusters.begin(), clusters.end(),
                      [](const Cluster& cluster) { return !cluster.hidden; }) == 1);
  const auto box = box_of(*whole, position_of(eye), kSide);
  REQUIRE(box);
  REQUIRE(box->shape_known);
  // Rays are 1 deg apart: a face's end is missed by up to range * 1 deg / sin(60 deg) or so, 1.6 cm
  // at 0.8 m, and its middle by half of that.
  CHECK(distance(box->centre, truth.centre) < 0.01);
  // Steps of 2 deg, and what a short face adds.
  CHECK(turned(box->yaw, truth.yaw) < 0.08);
}

TEST_CASE("walls and half hidden things are no boxes", "[transport]") {
  const PlanarPose eye{0.0, 0.0, 0.0};
  BoxMemory memory(kSide);
  for (int i = 0; i < 10; ++i) memory.see(look_from(eye, {}), kArena, {}, 0.3);
  CHECK(memory.boxes().empty());
  // The second peeps out behind the first.
  const std::vector<Box> boxes{{{0.6, 0.0}, 0.0, true}, {{1.0, 0.11}, 0.0, true}};
  const auto clusters = clusters_of(look_from(eye, boxes), kArena, 0.05, 0.07);
  REQUIRE(clusters.size() == 2);
  CHECK(clusters[0].hidden != clusters[1].hidden);
  memory.see(look_from(eye, boxes), kArena, {}, 0.3);
  REQUIRE(memory.boxes().size() == 1);
  CHECK(distance(memory.boxes()[0].box.centre, {0.6, 0.0}) < 0.01);
}

TEST_CASE("a box is remembered while it is hidden and forgotten when it is gone", "[transport]") {
  const PlanarPose eye{0.0, 0.0, 0.0};
  const Box far{{1.2, 0.0}, 0.2, true}, near{{0.5, 0.0}, 0.0, true};
  BoxMemory memory(kSide);
  for (int i = 0; i < 20; ++i) memory.see(look_from(eye, {far}), kArena, {}, 0.3);
  REQUIRE(memory.boxes().size() == 1);
  CHECK(memory.boxes()[0].seen == 20);
  for (int i = 0; i < 20; ++i) memory.see(look_from(eye, {near, far}), kArena, {}, 0.3);
  CHECK(memory.boxes().size() == 2);
  for (int i = 0; i < 20; ++i) memory.see(look_from(eye, {far}), kArena, {}, 0.3);
  REQUIRE(memory.boxes().size() == 1);
  CHECK(distance(memory.boxes()[0].box.centre, far.centre) < 0.03);
  // What another robot carries is not on the floor.
  const Box carried{{0.0, 0.9}, 0.0, true};
  for (int i = 0; i < 20; ++i) {
    memory.see(look_from(eye, {far, carried}), kArena, {{0.0, 1.1}}, 0.3);
  }
  CHECK(memory.boxes().size() == 1);
}

TEST_CASE("a tower is found by the side that is seen", "[transport]") {
  const double radius = 0.04;
  Cluster half;
  for (int i = 0; i <= 40; ++i) {
    // Parallel rays along +x: evenly spread across the tower.
    const double y = radius * (-0.98 + 1.96 * i / 40.0);
    half.points.push_back({2.0 - std::sqrt(radius * radius - y * y), y});
  }
  // The mean of sqrt(r^2 - y^2) over the width is pi r / 4, that of the docstring's even arc 2 r / pi.
  const PlanarPoint found = tower_of(half, {0.0, 0.0}, radius);
  CHECK(std::abs(found.x - 2.0) < radius * (kPi / 4 - 2 / kPi) + 1e-3);
  CHECK(std::abs(found.y) < 1e-9);
}

TEST_CASE("robots that drive at each other stop before their discs touch", "[transport]") {
  const double angle = GENERATE(0.0, 0.4, 0.9, 1.6);
  const bool both = GENERATE(false, true);
  Walker a, b;
  a.pose = {-1.2, 0.0, 0.0};
  b.pose = {1.2 * std::cos(angle), 1.2 * std::sin(angle), angle + kPi};
  b.rules.gives_way = both;
  double nearest = 10.0;
  for (int i = 0; i < 500; ++i) {
    const double time = i * 0.04;
    for (Walker* w : {&a, &b}) {
      const Walker& o = w == &a ? b : a;
      w->other.see(position_of(o.pose), time);
    }
    for (Walker* w : {&a, &b}) {
      if (!may_drive(w->pose, w->speed, w->radius, w->other, 0.27, w->rules)) continue;
      w->pose.x += 0.04 * w->speed * std::cos(w->pose.heading);
      w->pose.y += 0.04 * w->speed * std::sin(w->pose.heading);
    }
    nearest = std::min(nearest, distance(position_of(a.pose), position_of(b.pose)));
  }
  CHECK(nearest > 0.54);  // the two radii
}

TEST_CASE("the one that gives way stops first and the other keeps driving", "[transport]") {
  Walker a;
  a.pose = {0.0, 0.0, 0.0};
  // The other comes from the right, on a path that crosses ahead.
  for (int i = 0; i < 40; ++i) a.other.see({0.7, -1.05 + i * 0.014}, i * 0.04);
  REQUIRE(a.other.vy() == Approx(0.35).margin(0.01));
  CHECK(may_drive(a.pose, 0.35, 0.14, a.other, 0.27, a.rules));
  a.rules.gives_way = true;
  CHECK_FALSE(may_drive(a.pose, 0.35, 0.14, a.other, 0.27, a.rules));
  // Away from it always, and with no robot in sight.
  CHECK(may_drive(a.pose, -0.35, 0.14, a.other, 0.27, a.rules));
  CHECK(may_drive(a.pose, 0.35, 0.14, Neighbour(), 0.27, a.rules));
}
