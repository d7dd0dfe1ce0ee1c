// The components of the navigation experiment's plugins; that they reach their goals is shown by
// the example.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "cogrsim/algorithms/grid.h"
#include "cogrsim/algorithms/steering.h"
#include "grid_navigator/obstacle_map.h"
#include "grid_navigator/policy.h"
#include "grid_navigator/wheel_driver.h"
#include "maze_referee/hindsight.h"

using namespace grid_navigator;
using cogrsim::MazeModel;
using maze_referee::can_be_done;
using maze_referee::Cube;
using maze_referee::fewest_steps;
using maze_referee::Pace;
using maze_referee::Task;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;

/// Without inner walls.
MazeModel open_maze(int rows, int columns) {
  MazeModel maze;
  maze.rows = rows;
  maze.columns = columns;
  maze.cell = 0.5;
  maze.vertical.assign(static_cast<std::size_t>(rows * (columns + 1)), MazeModel::kOpen);
  maze.horizontal.assign(static_cast<std::size_t>((rows + 1) * columns), MazeModel::kOpen);
  for (int row = 0; row < rows; ++row) {
    maze.vertical[row * (columns + 1)] = MazeModel::kWall;
    maze.vertical[row * (columns + 1) + columns] = MazeModel::kWall;
  }
  for (int column = 0; column < columns; ++column) {
    maze.horizontal[column] = MazeModel::kWall;
    maze.horizontal[rows * columns + column] = MazeModel::kWall;
  }
  return maze;
}

/// Puts something west of a cell.
void west_of(MazeModel& maze, int row, int column, int what) {
  maze.vertical[row * (maze.columns + 1) + column] = what;
}

/// A vehicle that follows every command, every 10 ms, and stops at a wall seen by its front.
struct Vehicle {
  PlanarPose pose{0.25, 0.25, 0.0};
  double wall_x = kInfinity;  ///< something beyond this x
  double driven = 0.0;
  bool stopped_on_the_way = false;

  void run(WheelDriver& driver, double seconds, double jam_x = kInfinity) {
    for (double t = 0.0; t < seconds && !driver.idle(); t += 0.01) {
      const bool east = std::abs(pose.heading) < 0.5;
      const Velocity v = driver.update(pose, east ? wall_x - pose.x : kInfinity, 0.5, 0.01);
      pose.heading = cogrsim::wrapped_angle(pose.heading + v.turn * 0.01);
      const double x = pose.x + v.forward * 0.01 * std::cos(pose.heading);
      if (x > jam_x) continue;  // pushed in vain
      pose.x = x;
      pose.y += v.forward * 0.01 * std::sin(pose.heading);
      driven += std::abs(v.forward) * 0.01;
    }
  }
};

}  // namespace

TEST_CASE("an action leads to the middle of the neighbouring cell", "[navigation]") {
  const Action action = GENERATE(Action::north, Action::south, Action::east, Action::west);
  WheelDriver driver{DriverSettings{}};
  Vehicle vehicle;
  vehicle.pose = {1.26, 1.24, 0.7};  // a little off the middle of cell (2, 2)
  driver.start_in({2, 2}, vehicle.pose);
  REQUIRE(driver.idle());
  driver.begin(action);
  vehicle.run(driver, 10.0);
  REQUIRE(driver.idle());
  CHECK_FALSE(driver.blocked());
  const Cell to = neighbour({2, 2}, action);
  CHECK(driver.from() == to);
  // Along the path as near as `arrival` and what is driven while the speed runs out; aside it has
  // steered away most of the 1 cm.
  CHECK(vehicle.pose.x == Approx((to.column + 0.5) * 0.5).margin(0.015));
  CHECK(vehicle.pose.y == Approx((to.row + 0.5) * 0.5).margin(0.015));
  CHECK(cogrsim::wrapped_angle(vehicle.pose.heading - heading_of(action)) ==
        Approx(0.0).margin(0.1));
}

TEST_CASE("equal actions flow without a stop", "[navigation]") {
  WheelDriver driver{DriverSettings{}};
  Vehicle vehicle;
  driver.start_in({0, 0}, vehicle.pose);
  driver.begin(Action::east);
  double slowest = kInfinity;
  int extended = 0;
  for (double t = 0.0; t < 10.0 && !driver.idle(); t += 0.01) {
    if (driver.may_extend(vehicle.pose) && extended < 3) {
      driver.extend();
      ++extended;
    }
    const Velocity v = driver.update(vehicle.pose, kInfinity, 0.5, 0.01);
    vehicle.pose.heading += v.turn * 0.01;
    vehicle.pose.x += v.forward * 0.01 * std::cos(vehicle.pose.heading);
    if (vehicle.pose.x > 0.6 && vehicle.pose.x < 1.9) slowest = std::min(slowest, v.forward);
  }
  CHECK(extended == 3);
  CHECK(driver.from() == Cell{0, 4});
  CHECK(vehicle.pose.x == Approx(2.25).margin(0.015));
  CHECK(slowest > 0.49);
  CHECK(driver.finished() == 4);
}

TEST_CASE("an action against a wall ends blocked in the middle of its cell", "[navigation]") {
  WheelDriver driver{DriverSettings{}};
  Vehicle vehicle;
  driver.start_in({0, 0}, vehicle.pose);
  driver.begin(Action::east);
  SECTION("that is seen") { vehicle.wall_x = 0.5; }
  SECTION("that appears during the motion") { vehicle.wall_x = 0.85; }
  vehicle.run(driver, 10.0);
  REQUIRE(driver.idle());
  CHECK(driver.blocked());
  CHECK(driver.from() == Cell{0, 0});
  CHECK(vehicle.pose.x == Approx(0.25).margin(0.015));
}

TEST_CASE("what jams unseen is left after a time", "[navigation]") {
  WheelDriver driver{DriverSettings{}};
  Vehicle vehicle;
  driver.start_in({0, 0}, vehicle.pose);
  driver.begin(Action::east);
  vehicle.run(driver, 10.0, 0.5);
  REQUIRE(driver.idle());
  CHECK(driver.blocked());
  CHECK(vehicle.pose.x == Approx(0.25).margin(0.015));
}

TEST_CASE("a robot left between two cells goes to the middle of the nearer one", "[navigation]") {
  WheelDriver driver{DriverSettings{}};
  Vehicle vehicle;
  vehicle.pose = {0.25, 0.42, 0.0};
  driver.start_in({0, 0}, vehicle.pose);
  REQUIRE_FALSE(driver.idle());
  vehicle.run(driver, 10.0);
  REQUIRE(driver.idle());
  CHECK(driver.from() == Cell{0, 0});
  CHECK(vehicle.pose.y == Approx(0.25).margin(0.015));
}

TEST_CASE("odometry follows an arc and a reading draws it back", "[navigation]") {
  Localiser localiser(0.25);
  localiser.correct({1.0, 2.0, 0.0});
  // A quarter of a circle of radius 0.3 m to the left, wheels 0.2 m apart.
  for (int i = 0; i < 90; ++i) {
    localiser.roll(0.2 * kPi / 180, 0.4 * kPi / 180, 0.2);
  }
  CHECK(localiser.pose().x == Approx(1.3));
  CHECK(localiser.pose().y == Approx(2.3));
  CHECK(localiser.pose().heading == Approx(kPi / 2));
  localiser.correct({1.34, 2.3, kPi / 2});
  CHECK(localiser.pose().x == Approx(1.31));
}

TEST_CASE("beams that end inside of a cell mark it and walls do not", "[navigation]") {
  ObstacleMap map(open_maze(4, 4));
  const Cell own{0, 0};
  Beam beam{0.25, 0.25, 0.0, 0.0, true};
  // A wall 1.5 cm this side of the border at x = 1 m.
  beam.distance = 0.735;
  for (int i = 0; i < 10; ++i) CHECK(map.see(beam, own).empty());
  // The face of a cube in cell (0, 2): 15 cm beyond that border. One reading is not enough.
  beam.distance = 0.9;
  CHECK(map.see(beam, own).empty());
  CHECK(map.see(beam, own) == std::vector<Cell>{{0, 2}});
  CHECK(map.blocked({0, 2}));
  CHECK(map.count() == 1);
  // Seen through from another side, it is free again.
  Beam through{1.25, 1.25, -kPi / 2, 1.2, true};
  int changes = 0;
  for (int i = 0; i < 4; ++i) changes += static_cast<int>(map.see(through, {2, 2}).size());
  CHECK(changes == 1);
  CHECK_FALSE(map.blocked({0, 2}));
  // What ends in the robot's own cell is itself, or noise.
  beam.distance = 0.05;
  for (int i = 0; i < 5; ++i) CHECK(map.see(beam, own).empty());
}

TEST_CASE("of equally short paths the one with detours risks less", "[navigation]") {
  // From the south-west of 3 x 3 cells to the north-east, the paths along the south and the east
  // walled off into a corridor.
  MazeModel maze = open_maze(3, 3);
  for (const int column : {1, 2}) {
    maze.horizontal[maze.columns + column] = MazeModel::kWall;
  }
  west_of(maze, 1, 2, MazeModel::kWall);
  const auto found = risks(cogrsim::grid_of(maze), {0, 0}, {2, 2});
  // East: the corridor ends in (0, 2), walled to the north: no path of four steps begins there.
  REQUIRE(found.size() == 1);
  CHECK(found[0].first == Action::north);
  // Met at (0, 0), a cube in (1, 0) cuts the path: 9, the number of cells. After that there are two
  // paths to (2, 1), so nothing is lost with either of its cells; one in (2, 1) cuts it again.
  CHECK(found[0].second == 18);

  // Without walls both beginnings are alike.
  const auto open = risks(cogrsim::grid_of(open_maze(3, 3)), {0, 0}, {2, 2});
  REQUIRE(open.size() == 2);
  CHECK(open[0].second == open[1].second);

  // Three rows, the southern one a corridor with exits at its ends. A cube in it costs nothing at
  // (0, 1), 2 steps at (0, 2) and 4 at (0, 3); in the row above nothing at (1, 0), and 2 each at (1, 1)
  // and (1, 2), since there the third row leads around.
  MazeModel rows = open_maze(3, 4);
  for (const int column : {1, 2}) {
    rows.horizontal[rows.columns + column] = MazeModel::kWall;
  }
  const auto actions = risks(cogrsim::grid_of(rows), {0, 0}, {1, 3});
  REQUIRE(actions.size() == 2);
  for (const auto& [action, risk] : actions) CHECK(risk == (action == Action::east ? 6 : 4));
}

TEST_CASE("the optimum waits for the doors and knows when cubes come", "[navigation]") {
  // Two rooms of 2 x 2, a door in the south, the trigger in the north-west.
  MazeModel maze = open_maze(2, 4);
  west_of(maze, 0, 2, 0);
  west_of(maze, 1, 2, MazeModel::kWall);
  const Task task{{0, 1}, {1, 0}, {1, 3}};
  // To the trigger 2 steps; back 2, through the door 1, and 2 to the goal.
  CHECK(fewest_steps(maze, task, {}, Pace{}) == 7);
  // Without the errand it would have been 3.
  CHECK(fewest_steps(maze, {{0, 1}, {0, 1}, {1, 3}}, {}, Pace{}) == 3);
  // The robot stands behind the door, cell (0, 2), after 5 steps: a cube that comes at 5.5 s is too
  // late to block the path, one at 4.5 s cuts it.
  CHECK(fewest_steps(maze, task, {{{0, 2}, 5.5}}, Pace{}) == 7);
  CHECK_FALSE(fewest_steps(maze, task, {{{0, 2}, 4.5}}, Pace{}));
  // One of the two equal paths to the trigger is cut at once: no loss.
  CHECK(fewest_steps(maze, task, {{{0, 0}, 0.0}}, Pace{}) == 7);
}

TEST_CASE("the optimum pays for turns with time and not with length", "[navigation]") {
  // A corridor of five cells: 4 steps straight on.
  MazeModel maze = open_maze(1, 5);
  const Task task{{0, 0}, {0, 0}, {0, 4}};
  const Pace pace{1.0, 0.5, 0.75, cogrsim::Side::east};
  CHECK(fewest_steps(maze, task, {}, pace) == 4);
  // At (0, 3) after 3 s when it looks ahead at the start, 0.5 s later when it must turn first.
  const std::vector<Cube> late = {{{0, 3}, 3.25}};
  CHECK(fewest_steps(maze, task, late, pace) == 4);
  CHECK_FALSE(fewest_steps(maze, task, late, Pace{1.0, 0.5, 0.75, cogrsim::Side::north}));
  // To the west and back, two half turns: at (0, 3) after 1 + 3 steps and 1.5 s.
  const Task back{{0, 1}, {0, 0}, {0, 4}};
  CHECK(fewest_steps(maze, back, {{{0, 3}, 5.6}}, pace) == 5);
  CHECK_FALSE(fewest_steps(maze, back, {{{0, 3}, 5.4}}, pace));
}

TEST_CASE("a cube is fair while a path is left", "[navigation]") {
  MazeModel maze = open_maze(2, 4);
  west_of(maze, 0, 2, 0);
  west_of(maze, 1, 2, MazeModel::kWall);
  const Task task{{0, 1}, {1, 0}, {1, 3}};
  CHECK(can_be_done(maze, task, {0, 1}, false, {{{0, 0}, 0.0}}));
  CHECK_FALSE(can_be_done(maze, task, {0, 1}, false, {{{0, 0}, 0.0}, {{1, 1}, 0.0}}));
  // The same two do no harm to a robot that was at the trigger and is in the other room.
  CHECK(can_be_done(maze, task, {0, 2}, true, {{{0, 0}, 0.0}, {{1, 1}, 0.0}}));
  // Behind the door there is no detour.
  CHECK_FALSE(can_be_done(maze, task, {0, 1}, false, {{{0, 2}, 0.0}}));
}
