// Drives a base on omnidirectional wheels along poses. Wheel i stands at the angle a_i and the distance
// L from the middle and rolls along the tangent; across it, its rollers give way. For the velocity
// (v_x, v_y) and the turn rate w of the base, in its own axes,
//
//     speed_i = (-sin(a_i) v_x + cos(a_i) v_y + L w) / r
//
// The base drives straight to each pose, with v and w in proportion to what is left and bounded, and
// turns while it drives.
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"

namespace omni_drive {
namespace {

class OmniDrive final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    std::istringstream names(robot.parameter<std::string>("motors"));
    for (std::string name; names >> name;)
      wheels_.push_back(robot.motor(name, cogrsim::MotorMode::velocity));
    angles_ = robot.parameter<std::vector<double>>("angles");
    if (angles_.size() != wheels_.size() || angles_.empty())
      robot.fail("parameter 'angles': expected one for each of the " +
                 std::to_string(wheels_.size()) + " motors, found " +
                 std::to_string(angles_.size()));
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    distance_ = robot.parameter<double>("distance");
    radius_ = robot.parameter<double>("wheel_radius");
    speed_ = robot.parameter<double>("speed");
    turn_ = robot.parameter<double>("turn_rate");
    gain_ = robot.parameter<double>("gain");
    near_ = robot.parameter<double>("arrival");
    const auto waypoints = robot.parameter<std::vector<double>>("waypoints");
    const auto headings = robot.parameter<std::vector<double>>("headings");
    if (waypoints.empty() || waypoints.size() != 2 * headings.size())
      robot.fail(
          "parameters 'waypoints' and 'headings': expected a pair x y for each heading, "
          "found " +
          std::to_string(waypoints.size()) + " and " + std::to_string(headings.size()) +
          " numbers");
    for (std::size_t i = 0; 2 * i + 1 < waypoints.size() && i < headings.size(); ++i)
      goals_.push_back({waypoints[2 * i], waypoints[2 * i + 1], headings[i]});
    robot.publish("reached", 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid()) return;
    const cogrsim::PlanarPose here = cogrsim::planar(tracker_.pose());
    const cogrsim::PlanarPose& goal = goals_[std::min(next_, goals_.size() - 1)];
    const double dx = goal.x - here.x, dy = goal.y - here.y, left = std::hypot(dx, dy);
    const double turn = cogrsim::wrapped_angle(goal.heading - here.heading);
    if (next_ < goals_.size() && left < near_ && std::abs(turn) < 2 * near_ / distance_) ++next_;
    const double wanted = std::min(gain_ * left, speed_);
    // It gathers speed within about half a second; braking is up to the gain.
    now_ += std::clamp(wanted - now_, -1e9, 2 * speed_ * tick.period);
    const double scale = left > 0.0 ? now_ / left : 0.0;
    const double c = std::cos(here.heading), s = std::sin(here.heading);
    const double vx = scale * (c * dx + s * dy), vy = scale * (-s * dx + c * dy);
    const double w = std::clamp(gain_ * turn, -turn_, turn_);
    for (std::size_t i = 0; i < wheels_.size(); ++i)
      wheels_[i].set((-std::sin(angles_[i]) * vx + std::cos(angles_[i]) * vy + distance_ * w) /
                     radius_);
    robot_->publish("reached", static_cast<double>(next_));
  }

 private:
  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  std::vector<cogrsim::MotorHandle> wheels_;
  std::vector<double> angles_;
  cogrsim::PoseSensor tracker_;
  std::vector<cogrsim::PlanarPose> goals_;
  std::size_t next_ = 0;
  double distance_ = 0.0, radius_ = 0.0, speed_ = 0.0, turn_ = 0.0, gain_ = 0.0, near_ = 0.0;
  double now_ = 0.0;  // [m/s]
};

}  // namespace
}  // namespace omni_drive

COGRSIM_CONTROLLER(
    omni_drive::OmniDrive, "omni_drive", version("1.0.0"), author("CogRSim"),
    summary("drives a base on omnidirectional wheels along poses"),
    parameter("motors", "",
              "motors of the wheels, mode velocity; turning positive about an axis "
              "inward moves the base towards +angle")
        .must_be_set(),
    parameter("angles", std::vector<double>{}, "rad", "of each wheel, from x towards y")
        .must_be_set(),
    parameter("distance", 0.15, "m", "of the wheels from the middle")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("wheel_radius", 0.05, "m", "with its rollers").range(1e-4, 10.0).must_be_set(),
    parameter("pose", "tracker", "name of a pose sensor in the middle"),
    parameter("waypoints", std::vector<double>{}, "m", "positions x y, x y …").must_be_set(),
    parameter("headings", std::vector<double>{}, "rad", "one for each waypoint").must_be_set(),
    parameter("speed", 0.5, "m/s", "largest").range(1e-3, 100.0),
    parameter("turn_rate", 2.0, "rad/s", "largest").range(1e-3, 100.0),
    parameter("gain", 4.0, "1/s", "speed per distance").range(1e-3, 100.0),
    parameter("arrival", 0.03, "m", "a pose counts as reached this near").range(1e-4, 10.0),
    output("reached", "1", "number of poses that are reached"))
