// Drives through a maze with a known plan and unknown obstacles. See README.md.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/core/constants.h"
#include "obstacle_map.h"
#include "policy.h"
#include "wheel_driver.h"

namespace grid_navigator {
namespace {

using cogrsim::kInfinity;

/// Time for a door to open before the path through it is avoided for a while [s].
constexpr double kDoorPatience = 6.0;
/// Time for which a path with a jammed obstacle is avoided [s].
constexpr double kAvoid = 8.0;
/// Time of observation before planning again if no path is known [s].
constexpr double kLookAround = 0.5;
/// An object nearer than this that only the low range finders detect is a ball [m].
constexpr double kBallNear = 0.25, kBallGap = 0.05;
constexpr double kPushing = 0.6;  ///< fraction of the cruising speed with a ball in front

/// An edge of the map that is avoided until a given time.
struct Avoided {
  cogrsim::GridEdge edge;
  double until = 0.0;
};

class GridNavigator final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override;
  void update(const cogrsim::Tick& tick) override;
  std::optional<std::string> save() const override;
  void restore(const std::string& memory) override;

 private:
  bool configure_maze(cogrsim::Assembly& robot);
  void configure_sensors(cogrsim::Assembly& robot);
  void configure_policy(cogrsim::Assembly& robot);

  void localise();
  void look();
  double ahead() const;
  bool ball_ahead() const;
  void map_changed();
  void end_action();
  void decide(double time);
  void begin(const Cell& at, double time);
  void arrive_at(const Cell& cell);
  bool through_door(const Cell& from, Action action) const;
  std::optional<Action> next_action(const Cell& at, std::optional<Action> straight);
  void publish(const cogrsim::Tick& tick);
  Beam beam(std::size_t i) const;

  std::optional<cogrsim::Assembly> robot_;
  cogrsim::MotorHandle left_, right_;
  cogrsim::Encoder left_encoder_, right_encoder_;
  cogrsim::PoseSensor tracking_;
  std::vector<cogrsim::Infrared> high_, low_;
  std::vector<double> bearings_;     // of the high ones [rad]
  std::vector<std::uint64_t> seen_;  // of each high one, the last reading used
  double ring_ = 0.0, range_ = 0.0;  // [m]
  double radius_ = 0.0, track_ = 0.0, speed_ = 0.0;
  std::uint64_t tracked_ = 0;
  double last_left_ = 0.0, last_right_ = 0.0;  // [rad]
  bool rolling_ = false, placed_ = false;

  std::optional<cogrsim::MazeModel> maze_;
  Ends ends_;
  Errand errand_ = Errand::trigger;
  bool arrived_ = false;
  double errand_began_ = 0.0;  // [s]

  Localiser localiser_{0.2};
  WheelDriver driver_;
  ObstacleMap obstacles_;
  std::vector<Avoided> avoided_;
  std::unique_ptr<Policy> policy_;
  bool map_stale_ = true;
  double think_at_ = 0.0;           // [s]
  int finished_ = 0;                // number of processed actions of the driver
  std::optional<Cell> chosen_for_;  // the cell to which chosen_ belongs
  std::optional<Action> chosen_;
  std::optional<Outcome> under_way_;
  int plans_ = 0, blocked_ = 0;
  int shown_ = 0;  // index of the cell whose value is published next
};

void GridNavigator::configure(cogrsim::Assembly& robot) {
  robot_ = robot;
  left_ = robot.motor(robot.parameter<std::string>("left"), cogrsim::MotorMode::velocity);
  right_ = robot.motor(robot.parameter<std::string>("right"), cogrsim::MotorMode::velocity);
  left_encoder_ = robot.sensor<cogrsim::Encoder>(robot.parameter<std::string>("left_encoder"));
  right_encoder_ = robot.sensor<cogrsim::Encoder>(robot.parameter<std::string>("right_encoder"));
  tracking_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
  radius_ = robot.parameter<double>("wheel_radius");
  track_ = robot.parameter<double>("track");
  speed_ = robot.parameter<double>("speed");
  configure_sensors(robot);
  if (!configure_maze(robot)) return;

  DriverSettings settings;
  settings.cell = maze_->cell;
  settings.acceleration = robot.parameter<double>("acceleration");
  settings.turn_rate = robot.parameter<double>("turn_rate");
  settings.turn_acceleration = robot.parameter<double>("turn_acceleration");
  settings.clearance = robot.parameter<double>("clearance");
  driver_ = WheelDriver(settings);
  obstacles_ = ObstacleMap(*maze_);
  configure_policy(robot);
}

void GridNavigator::configure_sensors(cogrsim::Assembly& robot) {
  const std::string high = robot.parameter<std::string>("high");
  bearings_ = robot.parameter<std::vector<double>>("bearings");
  ring_ = robot.parameter<double>("ring");
  range_ = robot.parameter<double>("range");
  for (std::size_t i = 0; i < bearings_.size(); ++i) {
    high_.push_back(robot.sensor<cogrsim::Infrared>(high + std::to_string(i)));
  }
  seen_.assign(high_.size(), 0);
  const std::string low = robot.parameter<std::string>("low");
  const int count = robot.parameter<int>("low_count");
  for (int i = 0; i < count; ++i) {
    low_.push_back(robot.sensor<cogrsim::Infrared>(low + std::to_string(i)));
  }
  if (std::none_of(bearings_.begin(), bearings_.end(),
                   [](double b) { return std::abs(cogrsim::wrapped_angle(b)) < 1e-6; })) {
    robot.fail("parameter 'bearings': one of the high range finders must look ahead (0 deg)");
  }
}

bool GridNavigator::configure_maze(cogrsim::Assembly& robot) {
  const cogrsim::MazeModel* maze = robot.maze(robot.parameter<std::string>("maze"));
  if (maze == nullptr) return false;  // the error is reported
  maze_ = *maze;
  const auto cell = [&](const char* parameter) {
    const auto found = cogrsim::find_cell(*maze, robot.parameter<std::string>(parameter));
    if (!found) robot.fail(std::string("parameter '") + parameter + "': " + found.error().text());
    return found.value_or(Cell{});
  };
  ends_ = {cell("trigger"), cell("goal")};
  return true;
}

void GridNavigator::configure_policy(cogrsim::Assembly& robot) {
  const std::string name = robot.parameter<std::string>("policy");
  if (name == "q_learning" || name == "sarsa") {
    // The maze is deterministic, so a high learning rate is suitable.
    cogrsim::Parameters parameters{{"rate", 0.3}, {"discount", 0.97}};
    const std::string table = robot.parameter<std::string>("table");
    if (!table.empty()) {
      parameters["table"] = table;
      parameters["save_every"] = std::int64_t{1000};  // rehearsals count, too
    }
    auto learner = robot.algorithm<cogrsim::Learner>(name, parameters);
    if (!learner) return;  // the error is reported
    Rehearsal rehearsal;
    rehearsal.episodes = robot.parameter<int>("rehearsals");
    rehearsal.again = std::max(1, rehearsal.episodes / 5);
    policy_ = std::make_unique<LearnerPolicy>(std::move(learner), ends_, rehearsal,
                                              [this] { return robot_->uniform(0.0, 1.0); });
    return;
  }
  const auto planners = [&]() -> PlannerPolicy::Planners {
    return {robot.algorithm<cogrsim::GridPlanner>(name),
            robot.algorithm<cogrsim::GridPlanner>(name)};
  };
  PlannerPolicy::Planners to_trigger = planners(), to_goal = planners();
  if (to_trigger.path && to_trigger.value && to_goal.path && to_goal.value) {
    policy_ = std::make_unique<PlannerPolicy>(std::move(to_trigger), std::move(to_goal), ends_);
  }
}

void GridNavigator::localise() {
  if (left_encoder_.valid() && right_encoder_.valid()) {
    const double left = left_encoder_.position(), right = right_encoder_.position();
    if (rolling_) {
      localiser_.roll(radius_ * (left - last_left_), radius_ * (right - last_right_), track_);
    }
    rolling_ = true;
    last_left_ = left;
    last_right_ = right;
  }
  if (tracking_.valid() && tracking_.sequence() != tracked_) {
    tracked_ = tracking_.sequence();
    const cogrsim::Pose X_MR = maze_->X_WM.inverse() * tracking_.pose();
    const cogrsim::Vec3 forward = X_MR.q * cogrsim::Vec3::UnitX();
    localiser_.correct({X_MR.p.x(), X_MR.p.y(), std::atan2(forward.y(), forward.x())});
  }
}

Beam GridNavigator::beam(std::size_t i) const {
  const PlanarPose& pose = localiser_.pose();
  Beam out;
  out.direction = cogrsim::wrapped_angle(pose.heading + bearings_[i]);
  out.x = pose.x + ring_ * std::cos(out.direction);
  out.y = pose.y + ring_ * std::sin(out.direction);
  const double distance = high_[i].distance();
  out.hit = std::isfinite(distance);
  // A range below the minimum is minus infinity, and a range above the maximum plus infinity.
  out.distance = out.hit ? distance : (distance > 0 ? range_ : 0.0);
  return out;
}

void GridNavigator::look() {
  const Cell own = driver_.from();
  for (std::size_t i = 0; i < high_.size(); ++i) {
    if (!high_[i].valid() || high_[i].sequence() == seen_[i]) continue;
    seen_[i] = high_[i].sequence();
    if (!obstacles_.see(beam(i), own).empty()) map_stale_ = true;
  }
}

double GridNavigator::ahead() const {
  double nearest = kInfinity;
  for (std::size_t i = 0; i < high_.size(); ++i) {
    if (std::abs(cogrsim::wrapped_angle(bearings_[i])) > 1e-6 || !high_[i].valid()) continue;
    nearest = std::min(nearest, ring_ + std::max(0.0, high_[i].distance()));
  }
  return nearest;
}

bool GridNavigator::ball_ahead() const {
  const double wall = ahead();
  return std::any_of(low_.begin(), low_.end(), [&](const cogrsim::Infrared& eye) {
    if (!eye.valid()) return false;
    const double seen = ring_ + std::max(0.0, eye.distance());
    return seen < ring_ + kBallNear && seen < wall - kBallGap;
  });
}

bool GridNavigator::through_door(const Cell& from, Action action) const {
  switch (action) {
    case Action::north:
      return maze_->north(from.row, from.column) >= 0;
    case Action::south:
      return maze_->south(from.row, from.column) >= 0;
    case Action::east:
      return maze_->east(from.row, from.column) >= 0;
    case Action::west:
      break;
  }
  return maze_->west(from.row, from.column) >= 0;
}

// Updates the map of the planner: the plan, with open doors on the second errand, without blocked
// cells and edges to be avoided.
void GridNavigator::map_changed() {
  for (const Errand errand : {Errand::trigger, Errand::goal}) {
    if (errand < errand_) continue;
    cogrsim::Grid grid = cogrsim::grid_of(*maze_, errand == Errand::goal);
    for (int i = 0; i < grid.size(); ++i) {
      const Cell cell = grid.cell(i);
      // The cell of the robot and the target cell are never blocked.
      const bool needed = cell == driver_.from() || cell == ends_.trigger || cell == ends_.goal;
      if (obstacles_.blocked(cell) && !needed) (void)grid.set_cost(cell, cogrsim::kBlocked);
    }
    for (const Avoided& avoided : avoided_) (void)grid.set_cost(avoided.edge, cogrsim::kBlocked);
    policy_->set_map(errand, grid);
  }
  map_stale_ = false;
  chosen_for_.reset();
  ++plans_;
}

void GridNavigator::arrive_at(const Cell& cell) {
  if (errand_ == Errand::trigger && cell == ends_.trigger) {
    errand_ = Errand::goal;
    map_stale_ = true;
  } else if (errand_ == Errand::goal && cell == ends_.goal) {
    arrived_ = true;
  }
}

std::optional<Action> GridNavigator::next_action(const Cell& at, std::optional<Action> straight) {
  if (!chosen_for_ || *chosen_for_ != at) {
    chosen_for_ = at;
    chosen_ = policy_->choose(errand_, at, straight);
  }
  return chosen_;
}

// Processes the result of the last action.
void GridNavigator::end_action() {
  finished_ = driver_.finished();
  const Cell at = driver_.from();
  if (under_way_) {
    Outcome outcome = *under_way_;
    outcome.to = at;
    outcome.arrived = at == ends_.of(outcome.errand);
    policy_->learn(outcome);
    under_way_.reset();
  }
  chosen_for_.reset();
  arrive_at(at);
}

void GridNavigator::begin(const Cell& at, double time) {
  const PlanarPose& pose = localiser_.pose();
  std::optional<Action> straight;
  for (const Action action : kActions) {
    if (std::abs(cogrsim::wrapped_angle(heading_of(action) - pose.heading)) < 0.1)
      straight = action;
  }
  const std::optional<Action> action = next_action(at, straight);
  if (!action) {
    // A path must exist, so the detected obstacles are discarded and detected again.
    obstacles_.forget();
    avoided_.clear();
    map_stale_ = true;
    think_at_ = time + kLookAround;
    return;
  }
  under_way_ = Outcome{errand_, at, at, *action, false};
  driver_.begin(*action);
}

void GridNavigator::decide(double time) {
  const auto over = [&](const Avoided& avoided) { return avoided.until <= time; };
  const auto kept = std::remove_if(avoided_.begin(), avoided_.end(), over);
  if (kept != avoided_.end()) {
    avoided_.erase(kept, avoided_.end());
    map_stale_ = true;
  }

  if (driver_.finished() != finished_) {
    const Errand before = errand_;
    if (driver_.blocked()) {
      ++blocked_;
      const Cell at = driver_.from();
      const bool opening =
          through_door(at, driver_.action()) && time < errand_began_ + kDoorPatience;
      if (!opening) {
        avoided_.push_back({{at, driver_.action()}, time + kAvoid});
        map_stale_ = true;
      }
    }
    end_action();
    if (errand_ != before) errand_began_ = time;
  }
  if (map_stale_) map_changed();
  if (arrived_) return;

  if (driver_.idle()) {
    if (time >= think_at_) begin(driver_.from(), time);
    return;
  }
  // A turn that is useless on the new map is aborted.
  if (driver_.state() == WheelDriver::State::turning) {
    const auto action = next_action(driver_.from(), driver_.action());
    if (action && *action != driver_.action()) {
      under_way_.reset();
      driver_.break_off();
      begin(driver_.from(), time);
    }
    return;
  }
  const Cell target = driver_.target();
  // The target cell of the current action is blocked.
  if (obstacles_.blocked(target) && target != ends_.of(errand_)) {
    driver_.give_up();
    return;
  }
  if (!driver_.may_extend(localiser_.pose()) || target == ends_.of(errand_)) return;
  const auto next = next_action(target, driver_.action());
  if (!next || *next != driver_.action()) return;
  driver_.extend();
  end_action();
  under_way_ = Outcome{errand_, target, target, driver_.action(), false};
}

void GridNavigator::update(const cogrsim::Tick& tick) {
  localise();
  if (tracked_ == 0) return;  // the pose is not known yet
  const PlanarPose& pose = localiser_.pose();
  if (!placed_) {
    const Cell cell{static_cast<int>(std::floor(pose.y / maze_->cell)),
                    static_cast<int>(std::floor(pose.x / maze_->cell))};
    if (cell.row < 0 || cell.row >= maze_->rows || cell.column < 0 ||
        cell.column >= maze_->columns) {
      throw std::runtime_error("the robot is outside of the maze");
    }
    driver_.start_in(cell, pose);
    placed_ = true;
    if (driver_.idle()) arrive_at(cell);
  }
  look();
  decide(tick.time);
  const double cruise = ball_ahead() ? kPushing * speed_ : speed_;
  const Velocity v = driver_.update(pose, ahead(), cruise, tick.period);
  left_.set((v.forward - v.turn * track_ / 2) / radius_);
  right_.set((v.forward + v.turn * track_ / 2) / radius_);
  publish(tick);
}

void GridNavigator::publish(const cogrsim::Tick&) {
  robot_->publish("phase", arrived_ ? 2.0 : (errand_ == Errand::goal ? 1.0 : 0.0));
  robot_->publish("replans", plans_);
  robot_->publish("blocked", blocked_);
  robot_->publish("cubes", obstacles_.count());
  robot_->publish("action", driver_.idle() ? -1.0 : static_cast<double>(driver_.action()));
  const double forward = radius_ * (left_encoder_.velocity() + right_encoder_.velocity()) / 2;
  robot_->publish("speed", forward);

  const Cell cell{shown_ / maze_->columns, shown_ % maze_->columns};
  const cogrsim::Vec3 centre = cogrsim::centre_of(*maze_, cell);
  robot_->publish("value_x", centre.x());
  robot_->publish("value_y", centre.y());
  robot_->publish("value", policy_->value(Errand::goal, cell));
  robot_->publish("value_trigger", errand_ == Errand::trigger
                                       ? policy_->value(Errand::trigger, cell)
                                       : std::numeric_limits<double>::quiet_NaN());
  shown_ = (shown_ + 1) % (maze_->rows * maze_->columns);
}

// State in a snapshot: the errand, the detected obstacles and the learnt values. The pose is
// measured again; a current action ends at the nearest centre.
std::optional<std::string> GridNavigator::save() const {
  if (!placed_) return std::nullopt;
  std::ostringstream out;
  out << "grid_navigator 1\n"
      << static_cast<int>(errand_) << ' ' << arrived_ << ' ' << plans_ << ' ' << blocked_ << '\n';
  for (const int count : obstacles_.evidence()) out << count << ' ';
  out << '\n' << policy_->memory();
  return out.str();
}

void GridNavigator::restore(const std::string& memory) {
  std::istringstream in(memory);
  std::string kind;
  int version = 0, errand = 0;
  in >> kind >> version >> errand >> arrived_ >> plans_ >> blocked_;
  std::vector<int> evidence(obstacles_.evidence().size());
  for (int& count : evidence) in >> count;
  if (!in || kind != "grid_navigator" || version != 1 || errand < 0 || errand > 1) {
    throw std::runtime_error("this is not the state of a grid_navigator in this maze");
  }
  errand_ = static_cast<Errand>(errand);
  obstacles_.set_evidence(std::move(evidence));
  in.get();
  std::ostringstream rest;
  rest << in.rdbuf();
  if (!rest.str().empty()) policy_->remember(rest.str());
  map_stale_ = true;
}

}  // namespace
}  // namespace grid_navigator

COGRSIM_CONTROLLER(
    grid_navigator::GridNavigator, "grid_navigator", version("1.0.0"), author("CogRSim"),
    summary("drives a two-wheel robot through a maze by four actions and avoids obstacles"),
    parameter("maze", "", "name of the maze; empty: the only one"),
    parameter("trigger", "", "cell to go to first: a named cell, or \"r2c5\"").must_be_set(),
    parameter("goal", "", "cell to go to then").must_be_set(),
    parameter("policy", "d_star_lite",
              "method of choosing actions: a grid planner, or q_learning or sarsa"),
    parameter("table", "", "file in which a learner stores its table between runs; empty: none"),
    parameter("rehearsals", 2000, "simulated episodes of a learner before it starts, per errand")
        .range(0, 1e6),
    parameter("left", "left", "name of the left wheel's motor"),
    parameter("right", "right", "name of the right wheel's motor"),
    parameter("left_encoder", "turned_left", "name of the left wheel's encoder"),
    parameter("right_encoder", "turned_right", "name of the right wheel's encoder"),
    parameter("pose", "tracker", "name of the pose sensor; its +x points forward"),
    parameter("wheel_radius", 0.04, "m", "radius of both wheels").range(1e-3, 1.0).must_be_set(),
    parameter("track", 0.16, "m", "distance between the wheels' middles")
        .range(1e-3, 2.0)
        .must_be_set(),
    parameter("speed", 0.5, "m/s", "cruising speed").range(0.01, 5.0),
    parameter("acceleration", 2.0, "m/s^2", "of starting and braking").range(0.01, 50.0),
    parameter("turn_rate", 6.0, "rad/s", "of turns on the spot").range(0.1, 20.0),
    parameter("turn_acceleration", 30.0, "rad/s^2", "the same").range(0.1, 1000.0),
    parameter("clearance", 0.15, "m", "smallest distance of the centre to an obstacle ahead")
        .range(0.0, 1.0),
    parameter("high", "high_",
              "prefix of the range finders above the balls, followed by a number from 0"),
    parameter("bearings", std::vector<double>{0.0}, "rad",
              "direction of each of them, left positive"),
    parameter("ring", 0.1, "m", "radius of the circle on which all range finders are mounted")
        .range(0.0, 1.0),
    parameter("range", 2.0, "m", "maximum range of the high ones").range(0.05, 100.0),
    parameter("low", "low_", "prefix of those that detect balls too; all point ahead"),
    parameter("low_count", 0, "number of low range finders").range(0, 100),
    output("phase", "1", "0: driving to the trigger, 1: to the goal, 2: arrived"),
    output("replans", "1", "number of maps given to the planner so far"),
    output("blocked", "1", "number of actions that ended blocked so far"),
    output("cubes", "1", "number of cells believed to be blocked"),
    output("action", "1", "0 north, 1 south, 2 east, 3 west, -1 none"),
    output("speed", "m/s", "by the encoders"),
    output("value_x", "m", "centre of the cell of `value`, another one at every update"),
    output("value_y", "m", "the same"),
    output("value", "1", "for the goal: minus the remaining actions, or the learnt value"),
    output("value_trigger", "1", "the same for the trigger, until it is reached"))
