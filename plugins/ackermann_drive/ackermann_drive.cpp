// Drives a car along waypoints. A steering method (pure pursuit) gives the speed v and the curvature k
// that lead back to the path. The middle of the rear axle drives the circle of curvature k if all
// wheels turn about its centre (R. Ackermann; with the wheelbase L and the track b):
//
//     front:  tan(angle) = L k / (1 -+ k b/2)     left -, right +
//     rear:   speed = v (1 -+ k b/2) / r
//
// The speed is bounded by the sideways acceleration: v^2 |k| <= a.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"

namespace ackermann_drive {
namespace {

using cogrsim::PlanarPoint;

double distance_to_piece(const PlanarPoint& p, const PlanarPoint& a, const PlanarPoint& b) {
  const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
  const double at =
      square > 0.0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - at * dx, p.y - a.y - at * dy);
}

class AckermannDrive final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    steer_left_ =
        robot.motor(robot.parameter<std::string>("steer_left"), cogrsim::MotorMode::position);
    steer_right_ =
        robot.motor(robot.parameter<std::string>("steer_right"), cogrsim::MotorMode::position);
    left_ = robot.motor(robot.parameter<std::string>("drive_left"), cogrsim::MotorMode::velocity);
    right_ = robot.motor(robot.parameter<std::string>("drive_right"), cogrsim::MotorMode::velocity);
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    wheelbase_ = robot.parameter<double>("wheelbase");
    track_ = robot.parameter<double>("track");
    radius_ = robot.parameter<double>("wheel_radius");
    sideways_ = robot.parameter<double>("sideways_acceleration");
    sharpest_ = std::tan(robot.parameter<double>("max_steer")) / wheelbase_;
    task_.limits.max_speed = robot.parameter<double>("speed");
    task_.limits.acceleration = robot.parameter<double>("acceleration");
    task_.limits.max_turn = task_.limits.max_speed * sharpest_;
    task_.limits.turn_acceleration = std::numeric_limits<double>::infinity();
    cogrsim::Parameters settings;
    settings["lookahead"] = robot.parameter<double>("lookahead");
    settings["turn_on_the_spot"] = false;
    steering_ = robot.algorithm<cogrsim::Steering>("pure_pursuit", settings);

    const auto flat = robot.parameter<std::vector<double>>("waypoints");
    if (flat.size() < 4 || flat.size() % 2 != 0)
      robot.fail("parameter 'waypoints': expected at least two pairs x y, found " +
                 std::to_string(flat.size()) + " numbers");
    std::vector<PlanarPoint> lap;
    for (std::size_t i = 0; i + 1 < flat.size(); i += 2) lap.push_back({flat[i], flat[i + 1]});
    const int laps = robot.parameter<int>("laps");
    for (int i = 0; i < std::max(laps, 1); ++i)
      task_.path.insert(task_.path.end(), lap.begin(), lap.end());
    if (laps > 0 && !lap.empty()) task_.path.push_back(lap.front());
    robot.publish("off_path", 0.0);
    robot.publish("arrived", 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid() || !steering_) return;
    task_.pose = cogrsim::planar(tracker_.pose());
    task_.velocity = {speed_, speed_ * curvature_};
    task_.period = tick.period;
    const cogrsim::Result<cogrsim::SteeringCommand> command = steering_->steer(task_);
    if (!command) throw std::runtime_error(command.error().text());
    arrived_ = arrived_ || command->arrived;
    double speed = arrived_ ? std::max(speed_ - task_.limits.acceleration * tick.period, 0.0)
                            : command->velocity.forward;
    if (speed > 0.0 && !arrived_)
      curvature_ = std::clamp(command->velocity.turn / speed, -sharpest_, sharpest_);
    if (curvature_ != 0.0) speed = std::min(speed, std::sqrt(sideways_ / std::abs(curvature_)));
    speed_ = speed;

    const double half = curvature_ * track_ / 2.0;
    steer_left_.set(std::atan2(wheelbase_ * curvature_, 1.0 - half));
    steer_right_.set(std::atan2(wheelbase_ * curvature_, 1.0 + half));
    left_.set(speed_ * (1.0 - half) / radius_);
    right_.set(speed_ * (1.0 + half) / radius_);

    double off = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < task_.path.size(); ++i)
      off = std::min(
          off, distance_to_piece({task_.pose.x, task_.pose.y}, task_.path[i - 1], task_.path[i]));
    robot_->publish("off_path", off);
    robot_->publish("arrived", arrived_ ? 1.0 : 0.0);
  }

 private:
  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::MotorHandle steer_left_, steer_right_, left_, right_;
  cogrsim::PoseSensor tracker_;
  std::shared_ptr<cogrsim::Steering> steering_;
  cogrsim::SteeringTask task_;
  double wheelbase_ = 0.0, track_ = 0.0, radius_ = 0.0, sideways_ = 0.0;
  double sharpest_ = 0.0;  // largest curvature [1/m]
  double speed_ = 0.0, curvature_ = 0.0;
  bool arrived_ = false;
};

}  // namespace
}  // namespace ackermann_drive

COGRSIM_CONTROLLER(
    ackermann_drive::AckermannDrive, "ackermann_drive", version("1.0.0"), author("CogRSim"),
    summary("drives a car with Ackermann steering along waypoints"),
    parameter("steer_left", "steer_left", "motor of the left front wheel's angle, mode position"),
    parameter("steer_right", "steer_right", "motor of the right front wheel's angle"),
    parameter("drive_left", "left", "motor of the left rear wheel, mode velocity"),
    parameter("drive_right", "right", "motor of the right rear wheel"),
    parameter("pose", "tracker", "name of a pose sensor in the middle of the rear axle"),
    parameter("wheelbase", 0.26, "m", "from the rear to the front axle")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("track", 0.17, "m", "between the middles of the wheels of an axle")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("wheel_radius", 0.033, "m", "of the rear wheels").range(1e-4, 10.0).must_be_set(),
    parameter("max_steer", 0.5, "rad", "largest angle, of a wheel in the middle").range(0.01, 1.5),
    parameter("waypoints", std::vector<double>{}, "m", "positions x y, x y …").must_be_set(),
    parameter("laps", 0, "of a closed track; 0: once along the waypoints").range(0, 1000),
    parameter("speed", 1.5, "m/s", "on the straight").range(1e-3, 100.0),
    parameter("acceleration", 2.0, "m/s^2", "along the path").range(1e-3, 1000.0),
    parameter("sideways_acceleration", 3.0, "m/s^2", "bound in curves").range(1e-3, 1000.0),
    parameter("lookahead", 0.4, "m", "of pure pursuit").range(1e-3, 100.0),
    output("off_path", "m", "distance of the rear axle from the path"),
    output("arrived", "1", "1 at the end of the path"))
