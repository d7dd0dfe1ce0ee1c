// Steering of ideal vehicles, which follow every command: a unicycle driven along exact arcs.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cogrsim/algorithms/steering.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const double kPi = std::acos(-1.0);
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

void drive(PlanarPose& pose, const PlanarVelocity& velocity, double time) {
  const double half = 0.5 * velocity.turn * time;
  const double chord = velocity.forward * time * (half == 0.0 ? 1.0 : std::sin(half) / half);
  pose.x += chord * std::cos(pose.heading + half);
  pose.y += chord * std::sin(pose.heading + half);
  pose.heading += 2.0 * half;
}

/// A task without bounds of acceleration, so that the command is the wanted velocity.
SteeringTask nimble(std::vector<PlanarPoint> path) {
  SteeringTask task;
  task.path = std::move(path);
  task.period = 0.01;
  task.limits.max_speed = 0.5;
  task.limits.max_turn = 20.0;
  task.limits.acceleration = task.limits.turn_acceleration = kUnbounded;
  return task;
}

/// Steers until arrived or stuck, or for `seconds`.
SteeringCommand follow(Steering& steering, SteeringTask& task, double seconds) {
  SteeringCommand last;
  for (double t = 0.0; t < seconds; t += task.period) {
    const auto command = steering.steer(task);
    if (!command) FAIL(command.error().text());
    last = *command;
    task.velocity = last.velocity;
    if (last.arrived || last.stuck) break;
    drive(task.pose, task.velocity, task.period);
  }
  return last;
}

double gap(const PlanarPose& pose, const PlanarPoint& point) {
  return std::hypot(pose.x - point.x, pose.y - point.y);
}

}  // namespace

TEST_CASE("pure pursuit drives the arc 2 y / L^2", "[algorithms][steering]") {
  const double offset = GENERATE(0.1, -0.25, 0.0);
  auto steering = make<Steering>("pure_pursuit", {{"lookahead", 0.5}});
  SteeringTask task = nimble({{-1.0, offset}, {10.0, offset}});
  const auto command = steering->steer(task);
  REQUIRE(command);
  // The target lies on the line y = offset, 0.5 m from the origin.
  CHECK(command->target.y == Approx(offset).margin(1e-12));
  CHECK(std::hypot(command->target.x, command->target.y) == Approx(0.5));
  CHECK(command->velocity.forward == 0.5);
  CHECK(command->velocity.turn == Approx(0.5 * 2.0 * offset / 0.25).margin(1e-12));
  // The arc does meet the target: the chord of an arc of curvature k and chord L turns by
  // 2 asin(k L / 2).
  const double curvature = command->velocity.turn / command->velocity.forward;
  const double turned = 2.0 * std::asin(0.5 * curvature * 0.5);
  const double length = curvature == 0.0 ? 0.5 : turned / curvature;
  drive(task.pose, command->velocity, length / command->velocity.forward);
  CHECK(gap(task.pose, command->target) < 1e-12);
}

TEST_CASE("pure pursuit converges onto a line and stops at its end", "[algorithms][steering]") {
  auto steering = make<Steering>("pure_pursuit", {{"lookahead", 0.4}, {"arrival", 0.01}});
  SteeringTask task = nimble({{0.0, 0.0}, {6.0, 0.0}});
  task.pose.y = 0.3;
  task.limits.acceleration = 1.0;
  task.limits.turn_acceleration = 40.0;
  double before = 0.0;
  for (int step = 0; step < 800; ++step) {
    const auto command = steering->steer(task);
    REQUIRE(command);
    CHECK(std::abs(command->velocity.forward - before) <= 0.01 + 1e-12);
    before = command->velocity.forward;
    task.velocity = command->velocity;
    drive(task.pose, task.velocity, task.period);
  }
  // Near the line y'' = -(2/L^2) y - (2/L) y' per distance driven: e-folding length L, after more
  // than 3 m = 7.5 L below 0.3 exp(-7.5) sqrt(2) = 2.4e-4.
  CHECK(std::abs(task.pose.y) < 2.4e-4);
  const auto end = follow(*steering, task, 30.0);
  CHECK(end.arrived);
  CHECK(gap(task.pose, {6.0, 0.0}) <= 0.01);
  // It had braked before: it comes to rest within the remaining distance.
  while (task.velocity.forward > 0.0) {
    const auto command = steering->steer(task);
    REQUIRE(command);
    CHECK(command->arrived);
    task.velocity = command->velocity;
    drive(task.pose, task.velocity, task.period);
  }
  CHECK(gap(task.pose, {6.0, 0.0}) <= 0.01);
}

TEST_CASE("pure pursuit settles on a circle with its curvature", "[algorithms][steering]") {
  const double radius = 2.0;
  const int corners = 1440;
  std::vector<PlanarPoint> circle;
  for (int i = 0; i <= 3 * corners; ++i) {  // three rounds
    const double angle = 2.0 * kPi * i / corners;
    circle.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  auto steering = make<Steering>("pure_pursuit", {{"lookahead", 0.5}});
  SteeringTask task = nimble(circle);
  task.pose = {1.8, -0.1, 0.5 * kPi};
  SteeringCommand last;
  for (int step = 0; step < 5000; ++step) {  // 25 m, two of the rounds
    const auto command = steering->steer(task);
    REQUIRE(command);
    last = *command;
    task.velocity = last.velocity;
    drive(task.pose, task.velocity, task.period);
  }
  // On the circle the arc to a point of it is the circle itself. The polygon lies within the sagitta
  // R (1 - cos(pi / 1440)) = 4.8e-6 m of it; that shifts a target by as much, and the curvature by
  // 2 * 4.8e-6 / L^2 = 3.8e-5 of 0.5.
  CHECK(std::hypot(task.pose.x, task.pose.y) == Approx(radius).margin(1e-5));
  CHECK(last.velocity.turn / last.velocity.forward == Approx(1.0 / radius).margin(4e-5));
}

TEST_CASE("pure pursuit turns to a target behind it and keeps to crossing paths",
          "[algorithms][steering]") {
  auto steering = make<Steering>("pure_pursuit", {{"lookahead", 0.3}});
  SteeringTask task = nimble({{0.0, 0.0}, {-2.0, 0.1}});
  const auto command = steering->steer(task);
  REQUIRE(command);
  CHECK(command->velocity.forward == 0.0);
  CHECK(command->velocity.turn > 0.0);
  CHECK(follow(*steering, task, 30.0).arrived);
  // A figure of eight: the crossing is passed twice, all four corners are visited.
  task = nimble({{0.0, 0.0}, {2.0, 2.0}, {2.0, 0.0}, {0.0, 2.0}, {0.0, 0.0}});
  std::vector<double> nearest(4, kUnbounded);
  for (int step = 0; step < 4000; ++step) {
    const auto next = steering->steer(task);
    REQUIRE(next);
    if (next->arrived) break;
    task.velocity = next->velocity;
    drive(task.pose, task.velocity, task.period);
    for (std::size_t i = 0; i < 4; ++i)
      nearest[i] = std::min(nearest[i], gap(task.pose, task.path[i]));
  }
  // A corner is cut from where it is one look-ahead away.
  for (const double near : nearest) CHECK(near < 0.3);
  CHECK(gap(task.pose, {0.0, 0.0}) <= 0.05);
}

TEST_CASE("a potential field leads around an obstacle to the goal", "[algorithms][steering]") {
  auto steering = make<Steering>("potential_field", {{"repulsion", 2e-3}});
  SteeringTask task = nimble({{3.0, 0.0}});
  task.obstacles = {{1.5, 0.05}};
  double nearest = kUnbounded;
  SteeringCommand last;
  for (int step = 0; step < 4000 && !last.arrived; ++step) {
    const auto command = steering->steer(task);
    REQUIRE(command);
    last = *command;
    REQUIRE_FALSE(last.stuck);
    task.velocity = last.velocity;
    drive(task.pose, task.velocity, task.period);
    nearest = std::min(nearest, gap(task.pose, task.obstacles[0]));
  }
  CHECK(last.arrived);
  CHECK(nearest > task.radius);
}

TEST_CASE("a potential field reports its local minimum where it is", "[algorithms][steering]") {
  // An obstacle straight between: on the line the sum is k_a (3 - x) - k_r (1/d - 1/d_0) / d^2 with
  // d = 1.5 - x - radius, which vanishes at one point before the obstacle.
  const double k_r = 1e-3, reach = 0.4;
  auto steering = make<Steering>("potential_field", {{"repulsion", k_r}, {"reach", reach}});
  SteeringTask task = nimble({{3.0, 0.0}});
  task.obstacles = {{1.5, 0.0}};
  const auto sum = [&](double x) {
    const double d = 1.5 - x - task.radius;
    return (3.0 - x) - (d < reach ? k_r * (1.0 / d - 1.0 / reach) / (d * d) : 0.0);
  };
  double low = 1.0, high = 1.39;
  REQUIRE(sum(low) > 0.0);
  REQUIRE(sum(high) < 0.0);
  for (int i = 0; i < 60; ++i) (sum(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  // There it is stuck, a millimetre to the left it is not: the sum's slope is above 10 per second.
  task.pose.x = low;
  auto command = steering->steer(task);
  REQUIRE(command);
  CHECK(command->stuck);
  CHECK(has(command->why, "local minimum"));
  task.pose.x = low - 1e-3;
  command = steering->steer(task);
  REQUIRE(command);
  CHECK_FALSE(command->stuck);
  // And it drives there by itself: to where the sum is below 0.01 m/s, 1 mm at that slope.
  task.pose.x = 0.0;
  const SteeringCommand end = follow(*steering, task, 60.0);
  CHECK(end.stuck);
  CHECK_FALSE(end.arrived);
  CHECK(task.pose.x == Approx(low).margin(1e-3));
}

TEST_CASE("a dynamic window never chooses a velocity from which it cannot stop",
          "[algorithms][steering]") {
  RandomStream random(21, "window");
  int moving = 0;
  for (int scene = 0; scene < 40; ++scene) {
    auto steering = make<Steering>("dynamic_window", {{"margin", 0.0}});
    SteeringTask task;
    task.period = 0.1;
    task.radius = 0.15;
    task.limits = {0.8, scene % 2 == 0 ? 0.0 : 0.3, 2.5, 0.7, 3.0};
    task.path = {{0.0, 0.0}, {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)}};
    while (task.obstacles.size() < 25) {
      const PlanarPoint point{random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5)};
      if (std::hypot(point.x, point.y) > 0.3) task.obstacles.push_back(point);
    }
    for (int step = 0; step < 200; ++step) {
      const auto command = steering->steer(task);
      REQUIRE(command);
      const double v = command->velocity.forward, w = command->velocity.turn;
      // Within the window and the limits.
      CHECK(std::abs(v - task.velocity.forward) <= 0.7 * 0.1 + 1e-9);
      CHECK(std::abs(w - task.velocity.turn) <= 3.0 * 0.1 + 1e-9);
      CHECK(v <= 0.8 + 1e-12);
      CHECK(v >= -task.limits.max_reverse - 1e-12);
      CHECK(std::abs(w) <= 2.5 + 1e-12);
      // One period on, then braking along the same arc no harder than allowed, in small pieces.
      PlanarPose pose = task.pose;
      const double brake = w == 0.0 ? 0.7 : std::min(0.7, 3.0 * std::abs(v / w));
      const double piece = 1e-3;
      double nearest = kUnbounded;
      const double stop = v == 0.0 ? 0.0 : 0.1 + std::abs(v) / brake;
      for (double t = 0.0; t < stop; t += piece) {
        const double slower = std::max(0.0, 1.0 - brake * std::max(0.0, t - 0.1) / std::abs(v));
        drive(pose, {v * slower, w * slower}, piece);
        for (const PlanarPoint& point : task.obstacles)
          nearest = std::min(nearest, gap(pose, point));
      }
      // Speeds held over a piece overshoot the stopping distance by at most half a piece of travel,
      // v piece / 2 = 0.4 mm.
      CHECK(nearest > task.radius - 4e-4);
      moving += v != 0.0 ? 1 : 0;
      if (command->arrived && v == 0.0) break;
      task.velocity = command->velocity;
      drive(task.pose, task.velocity, task.period);
      for (const PlanarPoint& point : task.obstacles) {
        REQUIRE(gap(task.pose, point) > task.radius - 1e-6);
      }
    }
  }
  CHECK(moving > 500);  // it is not by standing still that it is safe
}

TEST_CASE("a dynamic window drives around obstacles", "[algorithms][steering]") {
  auto steering = make<Steering>("dynamic_window");
  SteeringTask task;
  task.limits = {0.5, 0.0, 2.0, 1.0, 6.0};
  task.path = {{4.0, 0.0}};
  for (int i = -4; i <= 4; ++i) task.obstacles.push_back({2.0, 0.05 * i + 0.03});
  const SteeringCommand end = follow(*steering, task, 60.0);
  INFO(end.why << " at " << task.pose.x << " " << task.pose.y);
  CHECK(end.arrived);
  // Without obstacles it goes straight there, at full speed less what speeding up and braking cost:
  // 4 m / 0.5 m/s + 0.5 s, and a period for each decision to brake.
  steering->reset();
  task.obstacles.clear();
  task.pose = {};
  task.velocity = {};
  double time = 0.0;
  for (; time < 60.0; time += task.period) {
    const auto command = steering->steer(task);
    REQUIRE(command);
    if (command->arrived) break;
    task.velocity = command->velocity;
    drive(task.pose, task.velocity, task.period);
  }
  CHECK(time < 4.0 / 0.5 + 0.5 + 1.0);
  CHECK(std::abs(task.pose.y) < 1e-9);
}

TEST_CASE("a dynamic window that cannot stop brakes and reports it", "[algorithms][steering]") {
  auto steering = make<Steering>("dynamic_window");
  SteeringTask task;
  task.limits = {1.0, 0.0, 2.0, 1.0, 6.0};
  task.velocity = {1.0, 0.0};
  task.path = {{4.0, 0.0}};
  for (int i = -20; i <= 20; ++i) task.obstacles.push_back({0.3, 0.05 * i});
  const auto command = steering->steer(task);
  REQUIRE(command);
  CHECK(command->stuck);
  CHECK(has(command->why, "no admissible velocity"));
  CHECK(command->velocity.forward == Approx(1.0 - 1.0 * task.period));
}

TEST_CASE("steering reports its errors", "[algorithms][steering]") {
  const std::string name =
      GENERATE(values<std::string>({"pure_pursuit", "potential_field", "dynamic_window"}));
  auto steering = make<Steering>(name);
  const double nan = std::nan("");
  const auto complaint = [&](auto&& change) {
    SteeringTask task;
    task.path = {{1.0, 0.0}};
    change(task);
    return said(steering->steer(task));
  };
  CHECK(complaint([](SteeringTask&) {}).empty());
  CHECK(has(complaint([](SteeringTask& t) { t.path.clear(); }), "the path is empty"));
  CHECK(has(complaint([&](SteeringTask& t) { t.pose.heading = nan; }), "the pose is (0, 0, nan)"));
  CHECK(has(complaint([&](SteeringTask& t) { t.velocity.turn = kUnbounded; }), "present velocity"));
  CHECK(has(complaint([&](SteeringTask& t) { t.path = {{0, 0}, {nan, 0}}; }), "path point 1"));
  CHECK(has(complaint([&](SteeringTask& t) {
              t.obstacles = {{0, -kUnbounded}};
            }),
            "obstacle point 0"));
  CHECK(has(complaint([](SteeringTask& t) { t.limits.max_speed = 0.0; }), "max_speed is 0"));
  CHECK(has(complaint([](SteeringTask& t) { t.limits.max_turn = kUnbounded; }),
            "max_turn must be finite"));
  CHECK(has(complaint([&](SteeringTask& t) { t.period = nan; }), "period is nan"));
  CHECK(has(complaint([](SteeringTask& t) { t.radius = -1.0; }), "radius is -1"));
  // At the goal already, and a path without length.
  SteeringTask task;
  task.path = {{0.0, 0.0}, {0.0, 0.0}};
  const auto there = steering->steer(task);
  REQUIRE(there);
  CHECK(there->arrived);
  CHECK(there->velocity.forward == 0.0);
  // On top of an obstacle: an answer, and one of numbers.
  task.path = {{1.0, 0.0}};
  task.obstacles = {{0.0, 0.0}};
  const auto inside = steering->steer(task);
  REQUIRE(inside);
  CHECK(std::isfinite(inside->velocity.forward));
  CHECK(std::isfinite(inside->velocity.turn));
}

TEST_CASE("ranges become points and angles stay wrapped", "[algorithms][steering]") {
  const auto points = ray_ends({1.0, 0.0, 0.5 * kPi}, {0.0, 0.5 * kPi, 0.0, 0.0, 0.0},
                               {2.0, 1.0, kUnbounded, std::nan(""), -kUnbounded});
  REQUIRE(points.size() == 2);
  CHECK(points[0].x == Approx(1.0));
  CHECK(points[0].y == Approx(2.0));
  CHECK(points[1].x == Approx(0.0).margin(1e-15));
  CHECK(wrapped_angle(3.0 * kPi) == Approx(kPi));
  CHECK(wrapped_angle(-kPi) == Approx(kPi));
  CHECK(wrapped_angle(7.0) == Approx(7.0 - 2.0 * kPi));
  const Pose turned(Vec3(1, 2, 3), Quat(Eigen::AngleAxisd(0.7, Vec3::UnitZ())));
  CHECK(planar(turned).heading == Approx(0.7));
}
