// Fetches boxes and brings them to a zone, together with another robot of the same kind. See
// README.md.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/algorithms/grid_planner.h"
#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/core/constants.h"
#include "sightings.h"
#include "traffic.h"

namespace box_carrier {
namespace {

using cogrsim::kPi;

constexpr double kCell = 0.1;        ///< size of the cells of the planning grid [m]
constexpr double kLargest = 50.0;    ///< largest side of an arena, which one grid covers [m]
constexpr double kPlanEvery = 0.25;  ///< period of planning [s]
constexpr double kStandOff = 0.24;   ///< distance from the fork to a box before docking [m]
constexpr double kCreep = 0.12;      ///< docking, setting down, backing off [m/s]
constexpr double kTouch = 0.006;     ///< feeler range at which the fork is at the box [m]
constexpr double kHolds = 0.025;     ///< feeler range below which the box is held [m]
constexpr double kLiftTime = 0.7, kGripTime = 0.3;  ///< [s]
constexpr double kBackOff = 0.2;                    ///< [m]
constexpr int kSure = 4;  ///< number of scans that must have seen a box before it is fetched
/// Time without progress after which the robot retreats; first: the one that gives way.
constexpr double kPatience = 3.0, kLongPatience = 8.0;  ///< [s]
constexpr double kRetreat = 4.0;                        ///< duration of a retreat [s]
constexpr double kFar = 1.3;  ///< beyond this distance the other robot is no reason to retreat [m]

enum class Phase {
  idle,
  fetch,
  face,
  dock,
  grip,
  lift,
  back,
  carry,
  turn,
  enter,
  lower,
  release,
  leave,
  retreat
};

class BoxCarrier final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override;
  void update(const cogrsim::Tick& tick) override;

 private:
  Rectangle rectangle(cogrsim::Assembly& robot, const std::string& name) const;
  void localise(double period);
  void look(double time);
  Scan scan_of(const cogrsim::Lidar& lidar) const;
  void run_phase(double time, double period);
  void enter_phase(Phase phase, double time);
  void approach_box(double time, double period);
  void pick_up(double time, double period);
  void dock(double time, double period);
  void check_hold(double time);
  void bring_to_slot(double time, double period);
  void set_down(double time);
  void retreat_if_blocked(double time);

  bool choose_box();
  bool update_target();
  std::optional<double> approach_to(const Box& box, std::optional<double> before) const;
  PlanarPoint stand_of(const Box& box, double approach) const;
  bool choose_slot();
  bool zone_taken() const;

  void drive_to(const PlanarPoint& goal, double time, double period);
  void plan(const PlanarPoint& goal, double time);
  std::vector<PlanarPoint> obstacles() const;
  void follow(const PlanarPoint& from, const PlanarPoint& to, double speed, double period);
  bool turn_to(double heading);
  PlanarPoint refuge() const;
  void move(double forward, double turn);
  void send(double period);
  void publish();

  double radius() const { return holding_ ? loaded_radius_ : radius_; }
  PlanarPoint here() const { return position_of(pose_); }
  /// Before the slot, south of the zone.
  PlanarPoint gate() const { return {slot_.x, zone_.south - 0.32}; }
  double bearing_of(const PlanarPoint& p) const { return std::atan2(p.y - pose_.y, p.x - pose_.x); }

  std::optional<cogrsim::Assembly> robot_;
  cogrsim::MotorHandle left_, right_, lift_;
  cogrsim::PoseSensor tracking_;
  cogrsim::Lidar low_, high_;
  cogrsim::Infrared feeler_;
  std::vector<double> low_bearings_, high_bearings_;
  std::uint64_t tracked_ = 0, low_seen_ = 0, high_seen_ = 0;

  Rectangle arena_, zone_;
  PlanarPoint home_;
  TrafficRules rules_;
  double wheel_ = 0.04, track_ = 0.16, speed_ = 0.35, side_ = 0.12, tower_ = 0.04;
  double fork_ = 0.125, lift_height_ = 0.03, radius_ = 0.14, loaded_radius_ = 0.27;
  bool from_east_ = false;

  std::shared_ptr<cogrsim::GridPlanner> planner_;
  std::shared_ptr<cogrsim::Steering> steering_, pursuit_;

  PlanarPose pose_;
  bool placed_ = false;
  cogrsim::PlanarVelocity wanted_, sent_;
  Neighbour other_;
  BoxMemory memory_;

  Phase phase_ = Phase::idle;
  double since_ = 0.0;  ///< when the phase began [s]
  PlanarPoint began_;   ///< position at that time [m]
  bool holding_ = false, gripping_ = false, raised_ = false;
  std::optional<Box> target_;
  std::optional<double> approach_;  ///< direction from the box to the robot [rad]
  PlanarPoint slot_, goal_;
  std::vector<PlanarPoint> path_;
  double planned_at_ = -1e9;
  bool arrived_ = false;
  double moved_at_ = 0.0, patience_ = kPatience;
  PlanarPoint moved_from_;
  int retreats_ = 0, fetched_ = 0;
};

Rectangle BoxCarrier::rectangle(cogrsim::Assembly& robot, const std::string& name) const {
  const auto list = robot.parameter<std::vector<double>>(name);
  if (list.size() != 4 || !(list[0] < list[1]) || !(list[2] < list[3])) {
    robot.fail("parameter '" + name + "': expected west, east, south and north, in this order");
    return {};
  }
  return {list[0], list[1], list[2], list[3]};
}

void BoxCarrier::configure(cogrsim::Assembly& robot) {
  robot_ = robot;
  left_ = robot.motor("left");
  right_ = robot.motor("right");
  lift_ = robot.motor("lift");
  tracking_ = robot.sensor<cogrsim::PoseSensor>("tracker");
  low_ = robot.sensor<cogrsim::Lidar>("low");
  high_ = robot.sensor<cogrsim::Lidar>("high");
  feeler_ = robot.sensor<cogrsim::Infrared>("feeler");
  arena_ = rectangle(robot, "arena");
  zone_ = rectangle(robot, "zone");
  const double width = arena_.east - arena_.west, depth = arena_.north - arena_.south;
  if (std::min(width, depth) < 1.0 || std::max(width, depth) > kLargest) {
    robot.fail("parameter 'arena': each side must be 1 m to 50 m long");
  }
  if (!arena_.contains({zone_.west, zone_.south}) || !arena_.contains({zone_.east, zone_.north})) {
    robot.fail("parameter 'zone': it must lie within the arena");
  }
  wheel_ = robot.parameter<double>("wheel_radius");
  track_ = robot.parameter<double>("track");
  speed_ = robot.parameter<double>("speed");
  side_ = robot.parameter<double>("box");
  tower_ = robot.parameter<double>("tower");
  fork_ = robot.parameter<double>("fork");
  lift_height_ = robot.parameter<double>("lift_height");
  radius_ = robot.parameter<double>("radius");
  loaded_radius_ = robot.parameter<double>("loaded_radius");
  rules_.gives_way = robot.parameter<bool>("gives_way");
  patience_ = rules_.gives_way ? kPatience : kLongPatience;
  planner_ = robot.algorithm<cogrsim::GridPlanner>(robot.parameter<std::string>("planner"));
  steering_ = robot.algorithm<cogrsim::Steering>(robot.parameter<std::string>("steering"));
  pursuit_ =
      robot.algorithm<cogrsim::Steering>("pure_pursuit", {{"lookahead", 0.15}, {"arrival", 0.005}});
  memory_ = BoxMemory(side_);
}

void BoxCarrier::localise(double period) {
  // Between two readings it moves with the commanded velocity.
  if (placed_) {
    pose_.x += sent_.forward * period * std::cos(pose_.heading);
    pose_.y += sent_.forward * period * std::sin(pose_.heading);
  }
  if (!tracking_.valid() || tracking_.sequence() == tracked_) return;
  tracked_ = tracking_.sequence();
  const PlanarPose measured = cogrsim::planar(tracking_.pose());
  const double trust = placed_ ? 0.3 : 1.0;
  pose_.x += trust * (measured.x - pose_.x);
  pose_.y += trust * (measured.y - pose_.y);
  pose_.heading = measured.heading;
  if (!placed_) {
    home_ = began_ = moved_from_ = here();
    from_east_ = home_.x > (zone_.west + zone_.east) / 2;
  }
  placed_ = true;
}

Scan BoxCarrier::scan_of(const cogrsim::Lidar& lidar) const {
  Scan scan;
  scan.sensor = pose_;
  scan.ranges = lidar.ranges();
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const cogrsim::Vec3 d = lidar.direction(i);
    scan.bearings.push_back(std::atan2(d.y(), d.x()));
  }
  return scan;
}

void BoxCarrier::look(double time) {
  if (high_.valid() && high_.sequence() != high_seen_) {
    high_seen_ = high_.sequence();
    // Only the walls and the tower of the other robot are that high.
    const auto clusters = clusters_of(scan_of(high_), arena_, 0.08, 0.06);
    const auto largest = std::max_element(
        clusters.begin(), clusters.end(),
        [](const Cluster& a, const Cluster& b) { return a.points.size() < b.points.size(); });
    if (largest != clusters.end()) other_.see(tower_of(*largest, here(), tower_), time);
  }
  if (low_.valid() && low_.sequence() != low_seen_) {
    low_seen_ = low_.sequence();
    Scan scan = scan_of(low_);
    // A carried box hides everything in front of it.
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const bool own = scan.ranges[i] < fork_ + 0.2 && std::abs(scan.bearings[i]) < 1.0;
      if (own && gripping_) scan.ranges[i] = std::numeric_limits<double>::quiet_NaN();
    }
    std::vector<PlanarPoint> masked;
    if (other_.position()) masked.push_back(*other_.position());
    memory_.see(scan, arena_, masked, loaded_radius_ + 0.05);
  }
}

PlanarPoint BoxCarrier::stand_of(const Box& box, double approach) const {
  const double away = fork_ + kStandOff + side_ / 2;
  return {box.centre.x + away * std::cos(approach), box.centre.y + away * std::sin(approach)};
}

// The side from which to take a box: the nearest one with enough free space. If a side was chosen
// before, the one closest to that.
std::optional<double> BoxCarrier::approach_to(const Box& box, std::optional<double> before) const {
  const double first = box.shape_known ? box.yaw : bearing_of(box.centre) + kPi;
  std::optional<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const double approach = cogrsim::wrapped_angle(first + k * kPi / 2);
    const PlanarPoint stand = stand_of(box, approach);
    if (!arena_.contains(stand, radius_ + 0.04) || zone_.contains(stand, -radius_)) continue;
    const bool free = std::none_of(memory_.boxes().begin(), memory_.boxes().end(),
                                   [&](const BoxMemory::Known& k2) {
                                     return distance(k2.box.centre, box.centre) > 0.1 &&
                                            distance(k2.box.centre, stand) < radius_ + 0.75 * side_;
                                   });
    if (!free) continue;
    const double cost =
        before ? std::abs(cogrsim::wrapped_angle(approach - *before)) : distance(here(), stand);
    if (cost < least) least = cost, best = approach;
  }
  return best;
}

bool BoxCarrier::choose_box() {
  const double claimed = rules_.gives_way ? 0.7 : 0.5;
  double least = std::numeric_limits<double>::infinity();
  target_.reset();
  for (const BoxMemory::Known& known : memory_.boxes()) {
    if (known.seen < kSure || zone_.contains(known.box.centre)) continue;
    double cost = distance(here(), known.box.centre);
    if (other_.position()) {
      const double its = distance(*other_.position(), known.box.centre);
      if (its < claimed) continue;  // the other robot is about to take it
      cost += 0.5 * std::max(0.0, 1.2 - its);
    }
    const auto approach = approach_to(known.box, std::nullopt);
    if (!approach || cost >= least) continue;
    least = cost;
    target_ = known.box;
    approach_ = approach;
  }
  return target_.has_value();
}

// Updates the position of the target box; false: the box is gone, or the other robot takes it.
bool BoxCarrier::update_target() {
  const BoxMemory::Known* nearest = nullptr;
  for (const BoxMemory::Known& known : memory_.boxes()) {
    if (distance(known.box.centre, target_->centre) < 0.12 &&
        (nearest == nullptr || distance(known.box.centre, target_->centre) <
                                   distance(nearest->box.centre, target_->centre))) {
      nearest = &known;
    }
  }
  if (nearest == nullptr || zone_.contains(nearest->box.centre)) return false;
  if (other_.position()) {
    const double its = distance(*other_.position(), nearest->box.centre);
    if (its < (rules_.gives_way ? 0.6 : 0.45) && its < distance(here(), nearest->box.centre)) {
      return false;
    }
  }
  target_ = nearest->box;
  approach_ = approach_to(*target_, approach_);
  return approach_.has_value();
}

// The zone is filled from its far row, and each robot starts at its own side.
bool BoxCarrier::choose_slot() {
  const double pitch = 0.3;
  const double width = zone_.east - zone_.west, depth = zone_.north - zone_.south;
  const int columns = std::max(1, static_cast<int>(width / pitch));
  const int rows = std::max(1, static_cast<int>(depth / (2.0 * side_)));
  const auto taken = [&](const PlanarPoint& p) {
    return std::any_of(
        memory_.boxes().begin(), memory_.boxes().end(),
        [&](const BoxMemory::Known& k) { return distance(k.box.centre, p) < 1.5 * side_; });
  };
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      const int column = from_east_ ? columns - 1 - i : i;
      const double x = zone_.west + width * (column + 0.5) / columns;
      const double y = zone_.north - 0.9 * side_ - row * 2.0 * side_;
      bool free = !taken({x, y});
      // The approach to it must be free.
      for (int near = row + 1; near < rows; ++near) {
        free = free && !taken({x, zone_.north - 0.9 * side_ - near * 2.0 * side_});
      }
      if (!free) continue;
      slot_ = {x, y};
      return true;
    }
  }
  return false;
}

// Whether the other robot is working in the zone too close to the target of this robot.
bool BoxCarrier::zone_taken() const {
  if (!other_.position()) return false;
  const PlanarPoint& p = *other_.position();
  const double court = rules_.gives_way ? 0.7 : 0.45;
  return p.y > zone_.south - court && p.x > zone_.west - 0.35 && p.x < zone_.east + 0.35 &&
         std::abs(p.x - slot_.x) < 2 * loaded_radius_ + 0.25;
}

void BoxCarrier::plan(const PlanarPoint& goal, double time) {
  planned_at_ = time;
  goal_ = goal;
  const int columns = static_cast<int>(std::ceil((arena_.east - arena_.west) / kCell));
  const int rows = static_cast<int>(std::ceil((arena_.north - arena_.south) / kCell));
  cogrsim::Grid grid(rows, columns, cogrsim::GridMoves::eight);
  const auto middle = [&](const cogrsim::Cell& c) {
    return PlanarPoint{arena_.west + (c.column + 0.5) * kCell,
                       arena_.south + (c.row + 0.5) * kCell};
  };
  const auto cell = [&](const PlanarPoint& p) {
    return cogrsim::Cell{std::clamp(static_cast<int>((p.y - arena_.south) / kCell), 0, rows - 1),
                         std::clamp(static_cast<int>((p.x - arena_.west) / kCell), 0, columns - 1)};
  };
  // Cells near obstacles are expensive but not blocked, so that the robot can always leave them.
  const auto near = [](double gap) { return gap < 0.0 ? 40.0 : gap < 0.12 ? 3.0 : 0.0; };
  for (int i = 0; i < grid.size(); ++i) {
    const PlanarPoint p = middle(grid.cell(i));
    double cost = 1.0 + near(std::min({p.x - arena_.west, arena_.east - p.x, p.y - arena_.south,
                                       arena_.north - p.y}) -
                             radius());
    for (const BoxMemory::Known& known : memory_.boxes()) {
      cost += near(distance(known.box.centre, p) - radius() - 0.7 * side_);
    }
    if (other_.position()) {
      const double gap =
          distance(*other_.position(), p) - radius() - loaded_radius_ - rules_.margin;
      cost += gap < 0.0 ? 80.0 : gap < 0.3 ? 6.0 * (0.3 - gap) / 0.3 : 0.0;
    }
    (void)grid.set_cost(grid.cell(i), cost);
  }
  planner_->set_grid(std::move(grid));
  path_ = {here()};
  if (const auto found = planner_->plan(cell(here()), cell(goal))) {
    for (std::size_t i = 1; i + 1 < found->cells.size(); ++i) {
      path_.push_back(middle(found->cells[i]));
    }
  }
  path_.push_back(goal);
}

std::vector<PlanarPoint> BoxCarrier::obstacles() const {
  std::vector<PlanarPoint> out;
  constexpr double kNear = 1.1;
  const auto add = [&](const PlanarPoint& p) {
    if (distance(p, here()) < kNear) out.push_back(p);
  };
  for (double x = arena_.west; x <= arena_.east; x += kCell) {
    add({x, arena_.south});
    add({x, arena_.north});
  }
  for (double y = arena_.south; y <= arena_.north; y += kCell) {
    add({arena_.west, y});
    add({arena_.east, y});
  }
  for (const BoxMemory::Known& known : memory_.boxes()) {
    for (int k = 0; k < 8; ++k) {
      // Corners and centres of the faces.
      const double r = k % 2 == 0 ? side_ / 2 : side_ / std::sqrt(2.0);
      const double a = known.box.yaw + k * kPi / 4;
      add({known.box.centre.x + r * std::cos(a), known.box.centre.y + r * std::sin(a)});
    }
  }
  if (other_.position()) {
    for (int k = 0; k < 16; ++k) {
      const double a = k * kPi / 8;
      add({other_.position()->x + loaded_radius_ * std::cos(a),
           other_.position()->y + loaded_radius_ * std::sin(a)});
    }
  }
  return out;
}

void BoxCarrier::drive_to(const PlanarPoint& goal, double time, double period) {
  if (distance(goal, goal_) > 0.04 || time - planned_at_ >= kPlanEvery) plan(goal, time);
  cogrsim::SteeringTask task;
  task.pose = pose_;
  task.velocity = sent_;
  task.path = path_;
  task.obstacles = obstacles();
  task.radius = radius();
  task.period = period;
  // Slow near the goal and with a heading error, so that it does not circle around the goal.
  const double off = std::abs(
      cogrsim::wrapped_angle(bearing_of(path_.size() > 2 ? path_[2] : goal) - pose_.heading));
  task.limits.max_speed =
      std::min({holding_ ? 0.8 * speed_ : speed_, 0.06 + 0.8 * distance(here(), goal),
                off > 1.0 ? 0.05 : speed_});
  task.limits.max_turn = 2.0;
  task.limits.acceleration = 0.8;
  task.limits.turn_acceleration = 8.0;
  const bool jammed = time - moved_at_ > 1.5;
  const bool alone = !other_.position() || distance(*other_.position(), here()) > kFar;
  if (jammed && alone) {
    // Boxes are light, so touching one is better than being stuck.
    follow(here(), path_.size() > 2 ? path_[1] : goal, kCreep, period);
  } else if (const auto command = steering_->steer(task)) {
    move(command->velocity.forward, command->velocity.turn);
  } else {
    throw std::runtime_error(command.error().text());
  }
  arrived_ = distance(here(), goal) < 0.06;
  if (arrived_) move(0.0, 0.0);
}

void BoxCarrier::follow(const PlanarPoint& from, const PlanarPoint& to, double speed,
                        double period) {
  cogrsim::SteeringTask task;
  task.pose = pose_;
  task.velocity = sent_;
  task.path = {from, to};
  task.radius = radius();
  task.period = period;
  task.limits.max_speed = speed;
  task.limits.max_turn = 1.0;
  task.limits.acceleration = 0.8;
  task.limits.turn_acceleration = 8.0;
  const auto command = pursuit_->steer(task);
  if (!command) throw std::runtime_error(command.error().text());
  move(command->velocity.forward, command->velocity.turn);
}

bool BoxCarrier::turn_to(double heading) {
  const double off = cogrsim::wrapped_angle(heading - pose_.heading);
  const bool there = std::abs(off) < 0.02 && std::abs(sent_.turn) < 0.15;
  move(0.0, there ? 0.0 : std::clamp(3.0 * off, -1.5, 1.5));
  return there;
}

// Of several positions in the arena the one far from the other robot and near to this one.
PlanarPoint BoxCarrier::refuge() const {
  PlanarPoint best = home_;
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 1; i < 6; ++i) {
    for (int k = 1; k < 5; ++k) {
      const PlanarPoint p{arena_.west + (arena_.east - arena_.west) * i / 6.0,
                          arena_.south + (arena_.north - arena_.south) * k / 5.0};
      if (zone_.contains(p, -0.5)) continue;
      const double away = other_.position() ? std::min(1.4, distance(p, *other_.position())) : 0.0;
      // The path must not pass the other robot.
      const double past =
          other_.position() ? std::cos(bearing_of(p) - bearing_of(*other_.position())) : 0.0;
      const double merit = 2.0 * away - 0.7 * distance(p, here()) - 0.8 * std::max(0.0, past);
      if (merit > most) most = merit, best = p;
    }
  }
  return best;
}

void BoxCarrier::move(double forward, double turn) { wanted_ = {forward, turn}; }

void BoxCarrier::enter_phase(Phase phase, double time) {
  phase_ = phase;
  since_ = time;
  began_ = moved_from_ = here();
  moved_at_ = time;
  arrived_ = false;
  planned_at_ = -1e9;
}

void BoxCarrier::run_phase(double time, double period) {
  move(0.0, 0.0);
  switch (phase_) {
    case Phase::idle:
    case Phase::fetch:
    case Phase::face:
      approach_box(time, period);
      break;
    case Phase::dock:
    case Phase::grip:
    case Phase::lift:
    case Phase::back:
      pick_up(time, period);
      break;
    case Phase::carry:
    case Phase::turn:
    case Phase::enter:
      bring_to_slot(time, period);
      break;
    case Phase::lower:
    case Phase::release:
    case Phase::leave:
      set_down(time);
      break;
    case Phase::retreat:
      drive_to(goal_, time, period);
      if (arrived_ || time - since_ > kRetreat) {
        enter_phase(holding_ ? Phase::carry : Phase::idle, time);
      }
      break;
  }
  retreat_if_blocked(time);
}

// Chooses a box, drives to where docking begins, and turns to the box.
void BoxCarrier::approach_box(double time, double period) {
  if (phase_ == Phase::idle) {
    if (choose_box()) {
      enter_phase(Phase::fetch, time);
    } else {
      drive_to(home_, time, period);
    }
  } else if (!update_target()) {
    enter_phase(Phase::idle, time);
  } else if (phase_ == Phase::fetch) {
    drive_to(stand_of(*target_, *approach_), time, period);
    if (arrived_) enter_phase(Phase::face, time);
  } else if (turn_to(bearing_of(target_->centre))) {
    enter_phase(Phase::dock, time);
  }
}

// Drives the fork to the box, grips and lifts it, and backs off.
void BoxCarrier::pick_up(double time, double period) {
  const double lasted = time - since_;
  switch (phase_) {
    case Phase::dock:
      dock(time, period);
      break;
    case Phase::grip:
      if (lasted > kGripTime) {
        raised_ = true;
        enter_phase(Phase::lift, time);
      }
      break;
    case Phase::lift:
      if (lasted > kLiftTime) {
        holding_ = true;
        enter_phase(Phase::back, time);
      }
      break;
    default:
      if (distance(here(), began_) < kBackOff && lasted <= 2.0 * kBackOff / kCreep + 6.0) {
        move(-kCreep, 0.0);
      } else {
        check_hold(time);
      }
  }
}

void BoxCarrier::dock(double time, double period) {
  (void)update_target();
  const double range = feeler_.valid() ? feeler_.distance() : 1.0;
  const double left = std::isfinite(range) ? range : range < 0 ? 0.0 : 1.0;
  if (left <= kTouch) {
    gripping_ = true;
    enter_phase(Phase::grip, time);
  } else if (distance(here(), began_) > kStandOff + 0.1 || time - since_ > 8.0) {
    enter_phase(Phase::back, time);
  } else {
    const double a = bearing_of(target_->centre);
    follow(began_, {target_->centre.x + 0.3 * std::cos(a), target_->centre.y + 0.3 * std::sin(a)},
           left < 0.03 ? 0.4 * kCreep : kCreep, period);
  }
}

// Whether the box came along decides what follows.
void BoxCarrier::check_hold(double time) {
  const double range = feeler_.valid() ? feeler_.distance() : 1.0;
  holding_ = gripping_ && range < kHolds;
  // If it did not, its position or kind may be wrong, so it is observed again.
  if (target_) memory_.forget(target_->centre, 0.15);
  if (!holding_) gripping_ = raised_ = false;
  enter_phase(holding_ ? Phase::carry : Phase::idle, time);
}

// Drives to the gate of a free slot, turns north and enters the zone.
void BoxCarrier::bring_to_slot(double time, double period) {
  if (phase_ == Phase::carry) {
    if (!choose_slot()) {
      drive_to(home_, time, period);  // the zone is full
    } else if (zone_taken()) {
      // Next to the zone, on its own side.
      drive_to({from_east_ ? zone_.east + 0.65 : zone_.west - 0.65, zone_.south - 0.35}, time,
               period);
      arrived_ = false;
    } else {
      drive_to(gate(), time, period);
      if (arrived_) enter_phase(Phase::turn, time);
    }
  } else if (phase_ == Phase::turn) {
    if (turn_to(kPi / 2)) enter_phase(Phase::enter, time);
  } else if (pose_.y + fork_ + side_ / 2 >= slot_.y || time - since_ > 15.0) {
    raised_ = false;
    enter_phase(Phase::lower, time);
  } else {
    follow(gate(), {slot_.x, zone_.north}, kCreep, period);
  }
}

// Lowers the box, releases it and backs out of the zone.
void BoxCarrier::set_down(double time) {
  const double lasted = time - since_;
  if (phase_ == Phase::lower) {
    if (lasted <= kLiftTime) return;
    gripping_ = false;
    ++fetched_;
    enter_phase(Phase::release, time);
  } else if (phase_ == Phase::release) {
    if (lasted > kGripTime) enter_phase(Phase::leave, time);
  } else if (pose_.y <= gate().y || lasted > 12.0) {
    holding_ = false;
    enter_phase(Phase::idle, time);
  } else {
    move(-kCreep, 0.0);
  }
}

// A robot that has waited too long for the other one retreats.
void BoxCarrier::retreat_if_blocked(double time) {
  const bool travels =
      phase_ == Phase::fetch || phase_ == Phase::carry || (phase_ == Phase::idle && !arrived_);
  if (!travels || distance(here(), moved_from_) > 0.1) {
    moved_from_ = here();
    moved_at_ = time;
  }
  const bool near = other_.position() && distance(*other_.position(), here()) < kFar;
  const bool at_home = distance(here(), home_) < 0.1;
  if (travels && near && !at_home && time - moved_at_ > patience_) {
    ++retreats_;
    patience_ = (rules_.gives_way ? kPatience : kLongPatience) * robot_->uniform(1.0, 1.5);
    const PlanarPoint away = refuge();
    enter_phase(Phase::retreat, time);
    plan(away, time);
  }
}

void BoxCarrier::send(double period) {
  TrafficRules rules = rules_;
  // It gives way only while driving; while it handles a box, the other robot must keep its
  // distance.
  rules.gives_way = rules_.gives_way &&
                    (phase_ == Phase::fetch || phase_ == Phase::carry || phase_ == Phase::idle);
  if (!may_drive(pose_, wanted_.forward, radius(), other_, loaded_radius_, rules)) {
    wanted_.forward = 0.0;
  }
  const auto towards = [](double now, double aim, double change) {
    return now + std::clamp(aim - now, -change, change);
  };
  sent_.forward = towards(sent_.forward, wanted_.forward, 2.0 * period);
  sent_.turn = towards(sent_.turn, wanted_.turn, 20.0 * period);
  left_.set((sent_.forward - sent_.turn * track_ / 2) / wheel_);
  right_.set((sent_.forward + sent_.turn * track_ / 2) / wheel_);
  lift_.set(raised_ ? lift_height_ : 0.0);
}

void BoxCarrier::update(const cogrsim::Tick& tick) {
  localise(tick.period);
  if (!placed_) return;
  look(tick.time);
  run_phase(tick.time, tick.period);
  send(tick.period);
  publish();
}

void BoxCarrier::publish() {
  robot_->publish("grip", gripping_ ? 1.0 : 0.0);
  robot_->publish("phase", static_cast<double>(phase_));
  robot_->publish("known", static_cast<double>(memory_.boxes().size()));
  robot_->publish("fetched", fetched_);
  robot_->publish("retreats", retreats_);
  robot_->publish("speed", sent_.forward);
}

}  // namespace
}  // namespace box_carrier

COGRSIM_CONTROLLER(
    box_carrier::BoxCarrier, "box_carrier", version("1.0.0"), author("CogRSim"),
    summary("fetches boxes it sees and brings them to a zone, giving way to another robot"),
    parameter("arena", std::vector<double>{-2.0, 2.0, -1.5, 1.5}, "m",
              "inner faces of the walls: west, east, south, north"),
    parameter("zone", std::vector<double>{-0.6, 0.6, 0.98, 1.5}, "m",
              "target area of the boxes, likewise; it is entered from the south"),
    parameter("gives_way", false, "gives way to the other robot; exactly one of the two should"),
    parameter("planner", "a_star", "name of a grid planner"),
    parameter("steering", "dynamic_window", "name of a steering algorithm"),
    parameter("speed", 0.35, "m/s", "cruising speed").range(0.05, 2.0),
    parameter("box", 0.12, "m", "edge of the boxes").range(0.02, 1.0),
    parameter("tower", 0.04, "m", "radius of the other's tower").range(0.005, 0.5),
    parameter("fork", 0.125, "m", "from the robot's middle to the front of its fork")
        .range(0.01, 1.0),
    parameter("lift_height", 0.03, "m", "how far the fork rises").range(0.0, 1.0),
    parameter("radius", 0.14, "m", "of the disc that encloses the robot").range(0.01, 1.0),
    parameter("loaded_radius", 0.27, "m", "the same with a box; clearance around the other robot")
        .range(0.01, 2.0),
    parameter("wheel_radius", 0.04, "m", "radius of both wheels").range(1e-3, 1.0),
    parameter("track", 0.16, "m", "distance between the wheels' middles").range(1e-3, 2.0),
    output("grip", "1", "1: requests to hold the box at the fork"),
    output("phase", "1",
           "0 idle, 1 fetch, 2 face, 3 dock, 4 grip, 5 lift, 6 back, 7 carry, 8 turn, 9 enter, "
           "10 lower, 11 release, 12 leave, 13 retreat"),
    output("known", "1", "number of known boxes"),
    output("fetched", "1", "number of delivered boxes"),
    output("retreats", "1", "number of retreats from the other robot"),
    output("speed", "m/s", "commanded forward speed"))
