// Drives a vehicle with two wheels: by velocity commands, or along waypoints. See README.md.
#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"
#include "path_follower.h"

namespace diff_drive {
namespace {

/// Heading of a body whose x axis points forward [rad].
double heading_of(const cogrsim::Quat& q) {
  const cogrsim::Vec3 forward = q * cogrsim::Vec3::UnitX();
  return std::atan2(forward.y(), forward.x());
}

/// Moves `value` towards `wanted` by at most `change`.
double towards(double value, double wanted, double change) {
  return value + std::clamp(wanted - value, -change, change);
}

class DiffDrive final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override;
  void update(const cogrsim::Tick& tick) override;
  std::optional<std::string> save() const override;
  void restore(const std::string& memory) override;

 private:
  void configure_waypoints(cogrsim::Assembly& robot);
  void configure_commands(cogrsim::Assembly& robot);
  PlanarPose measured_pose();
  Velocity commanded(double time) const;

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::MotorHandle left_, right_;
  cogrsim::PoseSensor pose_sensor_;
  bool use_pose_sensor_ = false;
  double radius_ = 0.0, track_ = 0.0;                    // [m]
  double left_sign_ = 1.0, right_sign_ = 1.0;            // -1: mounted in reverse
  double acceleration_ = 0.0, turn_acceleration_ = 0.0;  // [m/s^2], [rad/s^2]
  Velocity constant_;
  std::vector<double> times_, speeds_, turn_rates_;  // commands that change over time
  bool follow_ = false;
  PathFollower follower_;
  PlanarPose odometry_;
  double last_left_ = 0.0, last_right_ = 0.0;  // wheel angles at the last update [rad]
  Velocity now_;                               // the current commanded velocity
  bool announced_ = false;
};

void DiffDrive::configure(cogrsim::Assembly& robot) {
  robot_ = robot;
  left_ = robot.motor(robot.parameter<std::string>("left"), cogrsim::MotorMode::velocity);
  right_ = robot.motor(robot.parameter<std::string>("right"), cogrsim::MotorMode::velocity);
  radius_ = robot.parameter<double>("wheel_radius");
  track_ = robot.parameter<double>("track");
  left_sign_ = robot.parameter<bool>("reverse_left") ? -1.0 : 1.0;
  right_sign_ = robot.parameter<bool>("reverse_right") ? -1.0 : 1.0;
  acceleration_ = robot.parameter<double>("acceleration");
  turn_acceleration_ = robot.parameter<double>("turn_acceleration");
  const std::string sensor = robot.parameter<std::string>("pose");
  use_pose_sensor_ = !sensor.empty();
  if (use_pose_sensor_) pose_sensor_ = robot.sensor<cogrsim::PoseSensor>(sensor);

  const auto start = robot.parameter<std::vector<double>>("start");
  if (start.size() == 2) {
    odometry_.x = start[0];
    odometry_.y = start[1];
  } else {
    robot.fail("parameter 'start': expected 2 numbers (x y), found " +
               std::to_string(start.size()));
  }
  odometry_.heading = robot.parameter<double>("start_heading");
  last_left_ = robot.joint_position(left_);
  last_right_ = robot.joint_position(right_);

  configure_waypoints(robot);
  configure_commands(robot);
}

void DiffDrive::configure_waypoints(cogrsim::Assembly& robot) {
  const auto flat = robot.parameter<std::vector<double>>("waypoints");
  follow_ = !flat.empty();
  if (!follow_) return;
  if (flat.size() % 2 != 0) {
    robot.fail("parameter 'waypoints': expected pairs x y, found " + std::to_string(flat.size()) +
               " numbers");
    return;
  }
  std::vector<Point> points;
  for (std::size_t i = 0; i + 1 < flat.size(); i += 2) points.push_back({flat[i], flat[i + 1]});
  FollowerSettings settings;
  settings.speed = std::abs(robot.parameter<double>("speed"));
  settings.max_turn = std::abs(robot.parameter<double>("turn_rate"));
  settings.turn_gain = robot.parameter<double>("turn_gain");
  settings.lookahead = robot.parameter<double>("lookahead");
  settings.arrival = robot.parameter<double>("arrival");
  settings.acceleration = acceleration_;
  settings.loop = robot.parameter<bool>("loop");
  if (settings.max_turn == 0.0) settings.max_turn = 2.0;
  if (settings.speed == 0.0) robot.fail("parameter 'speed' is 0: no waypoint would be reached");
  follower_ = PathFollower(std::move(points), settings);
}

void DiffDrive::configure_commands(cogrsim::Assembly& robot) {
  constant_ = {robot.parameter<double>("speed"), robot.parameter<double>("turn_rate")};
  times_ = robot.parameter<std::vector<double>>("times");
  speeds_ = robot.parameter<std::vector<double>>("speeds");
  turn_rates_ = robot.parameter<std::vector<double>>("turn_rates");
  if (times_.empty() && speeds_.empty() && turn_rates_.empty()) return;
  if (follow_) robot.fail("give either waypoints or times, speeds and turn_rates, not both");
  if (speeds_.size() != times_.size() || turn_rates_.size() != times_.size()) {
    robot.fail("times, speeds and turn_rates belong together: expected as many of each, found " +
               std::to_string(times_.size()) + ", " + std::to_string(speeds_.size()) + " and " +
               std::to_string(turn_rates_.size()));
  }
  if (!std::is_sorted(times_.begin(), times_.end())) {
    robot.fail("parameter 'times': expected rising times");
  }
}

PlanarPose DiffDrive::measured_pose() {
  // The odometry also runs with a sensor, and replaces it during dropouts.
  const double left = robot_->joint_position(left_), right = robot_->joint_position(right_);
  odometry_ = rolled(odometry_, left_sign_ * radius_ * (left - last_left_),
                     right_sign_ * radius_ * (right - last_right_), track_);
  last_left_ = left;
  last_right_ = right;
  if (use_pose_sensor_ && pose_sensor_.valid()) {
    const cogrsim::Pose pose = pose_sensor_.pose();
    odometry_ = {pose.p.x(), pose.p.y(), heading_of(pose.q)};
  }
  return odometry_;
}

Velocity DiffDrive::commanded(double time) const {
  if (times_.empty()) return constant_;
  const auto next = std::upper_bound(times_.begin(), times_.end(), time);
  if (next == times_.begin()) return {};
  const auto i = static_cast<std::size_t>(next - times_.begin()) - 1;
  return {speeds_[i], turn_rates_[i]};
}

void DiffDrive::update(const cogrsim::Tick& tick) {
  const PlanarPose pose = measured_pose();
  const Velocity wanted = follow_ ? follower_.update(pose) : commanded(tick.time);
  if (follow_ && follower_.done() && !announced_) {
    announced_ = true;
    robot_->report("diff_drive: reached the last waypoint");
  }
  now_.forward = towards(now_.forward, wanted.forward, acceleration_ * tick.period);
  now_.turn = towards(now_.turn, wanted.turn, turn_acceleration_ * tick.period);
  const WheelSpeeds wheels =
      limited(wheel_speeds(now_, radius_, track_), left_.max_speed(), right_.max_speed());
  left_.set(left_sign_ * wheels.left);
  right_.set(right_sign_ * wheels.right);
}

std::optional<std::string> DiffDrive::save() const {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  const PathFollower::Progress progress = follower_.progress();
  out << odometry_.x << ' ' << odometry_.y << ' ' << odometry_.heading << ' ' << last_left_ << ' '
      << last_right_ << ' ' << now_.forward << ' ' << now_.turn << ' ' << announced_ << ' '
      << progress.from.x << ' ' << progress.from.y << ' ' << progress.started << ' '
      << progress.done << ' ' << progress.next;
  return out.str();
}

void DiffDrive::restore(const std::string& memory) {
  std::istringstream in(memory);
  in.imbue(std::locale::classic());
  PathFollower::Progress progress;
  if (!(in >> odometry_.x >> odometry_.y >> odometry_.heading >> last_left_ >> last_right_ >>
        now_.forward >> now_.turn >> announced_ >> progress.from.x >> progress.from.y >>
        progress.started >> progress.done >> progress.next)) {
    throw std::runtime_error("the state is not that of a diff_drive");
  }
  if (follow_ && !follower_.resume(progress)) {
    throw std::runtime_error("the state belongs to a longer list of waypoints");
  }
}

}  // namespace
}  // namespace diff_drive

COGRSIM_CONTROLLER(
    diff_drive::DiffDrive, "diff_drive", version("1.0.0"), author("CogRSim"),
    summary("drives two wheels by velocity commands or along waypoints"),
    parameter("left", "left", "name of the left wheel's motor"),
    parameter("right", "right", "name of the right wheel's motor"),
    parameter("wheel_radius", 0.04, "m", "radius of both wheels").range(1e-4, 10.0).must_be_set(),
    parameter("track", 0.18, "m", "distance between the wheels' middles")
        .range(1e-4, 20.0)
        .must_be_set(),
    parameter("reverse_left", false, "the left motor drives backwards at positive speed"),
    parameter("reverse_right", false, "the right motor drives backwards at positive speed"),
    parameter("speed", 0.2, "m/s", "forward speed; with waypoints the cruising speed")
        .range(-20.0, 20.0),
    parameter("turn_rate", 0.0, "rad/s",
              "turn rate, left positive; with waypoints its limit (0: 2 rad/s)")
        .range(-50.0, 50.0),
    parameter("acceleration", 1.0, "m/s^2", "limit of the change of forward speed")
        .range(1e-3, 1000.0),
    parameter("turn_acceleration", 20.0, "rad/s^2", "limit of the change of turn rate")
        .range(1e-3, 1e4),
    parameter("times", std::vector<double>{}, "s", "start of each velocity command, rising"),
    parameter("speeds", std::vector<double>{}, "m/s", "forward speed of each command"),
    parameter("turn_rates", std::vector<double>{}, "rad/s", "turn rate of each command"),
    parameter("waypoints", std::vector<double>{}, "m", "positions x y, x y … to drive to"),
    parameter("loop", false, "after the last waypoint comes the first again"),
    parameter("lookahead", 0.1, "m", "look-ahead distance on the line").range(1e-3, 100.0),
    parameter("arrival", 0.03, "m", "a waypoint counts as reached this near").range(1e-4, 10.0),
    parameter("turn_gain", 4.0, "1/s", "turn rate per heading error").range(1e-3, 100.0),
    parameter("pose", "", "name of a pose sensor; empty: odometry from the wheels"),
    parameter("start", std::vector<double>{0.0, 0.0}, "m", "position x y where odometry starts"),
    parameter("start_heading", 0.0, "rad", "heading with which odometry starts").range(-7.0, 7.0))
