// Flies a quadrotor along waypoints by a cascade of two loops (T. Lee, M. Leok, N. McClamroch,
// Geometric tracking control of a quadrotor UAV on SE(3), 2010). With the reference r that moves
// along the waypoints, the mass m, the inertia J, the rotation R of the body and its angular
// velocity w in its own axes:
//
//     a = kp (r - p) + ki integral(r - p) + kd (r' - v) + g z      wanted acceleration, without gravity
//     f = m a . R z                                                thrust of all rotors
//     e = 1/2 vee(D^T R - R^T D)                                   D: z along a, x to the wanted heading
//     t = J (-n^2 e - 2 n w)                                       torque, critically damped with n
//
// Rotor i at (x_i, y_i), turning by s_i = +-1, gives the thrust T_i and the torque c s_i T_i about z:
//
//     T_i = f/4 + y_i t_x/(4 arm^2) - x_i t_y/(4 arm^2) + s_i t_z/(4 c),    |x_i| = |y_i| = arm
//
// Rotors have bounds, and follow with a first-order lag. Their inertia and gyroscopic moments are not
// modelled.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"

namespace quadrotor_pilot {
namespace {

using cogrsim::Mat3;
using cogrsim::Vec3;

// Front left, front right, rear right, rear left.
constexpr std::array<double, 4> kX = {1, 1, -1, -1}, kY = {1, -1, -1, 1}, kSpin = {1, -1, 1, -1};
const std::array<std::string, 4> kOutputs = {"rotor_1", "rotor_2", "rotor_3", "rotor_4"};

class QuadrotorPilot final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    mass_ = robot.parameter<double>("mass");
    arm_ = robot.parameter<double>("arm");
    yaw_per_thrust_ = robot.parameter<double>("yaw_per_thrust");
    strongest_ = robot.parameter<double>("max_thrust");
    lag_ = robot.parameter<double>("rotor_lag");
    gravity_ = robot.parameter<double>("gravity");
    speed_ = robot.parameter<double>("speed");
    heading_ = robot.parameter<double>("heading");
    slow_ = robot.parameter<double>("position_rate");
    fast_ = robot.parameter<double>("attitude_rate");
    tilt_ = std::tan(robot.parameter<double>("max_tilt"));
    const auto j = robot.parameter<std::vector<double>>("inertia");
    if (j.size() == 3)
      inertia_ = Vec3(j[0], j[1], j[2]);
    else
      robot.fail("parameter 'inertia': expected 3 numbers, about x, y and z");
    const auto flat = robot.parameter<std::vector<double>>("waypoints");
    if (flat.empty() || flat.size() % 3 != 0)
      robot.fail("parameter 'waypoints': expected positions x y z, found " +
                 std::to_string(flat.size()) + " numbers");
    for (std::size_t i = 0; i + 2 < flat.size(); i += 3)
      waypoints_.emplace_back(flat[i], flat[i + 1], flat[i + 2]);
    for (const std::string& name : kOutputs) robot.publish(name, 0.0);
    robot.publish("error", 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid()) return;
    const cogrsim::Pose pose = tracker_.pose();
    const cogrsim::Twist twist = tracker_.twist();
    if (!started_) reference_ = pose.p;
    started_ = true;
    const Vec3 drift = follow(tick.period);

    // Three equal poles: the error decays as fast as `slow_`, also under a constant wind.
    const double n = slow_;
    const Vec3 error = reference_ - pose.p;
    const Vec3 wanted = 3 * n * n * error + n * n * n * sum_ + 3 * n * (drift - twist.linear);
    Vec3 pull = wanted + Vec3(0, 0, gravity_);
    const double level = std::hypot(pull.x(), pull.y());
    pull.z() = std::max(pull.z(), 0.2 * gravity_);
    const bool bounded = level > tilt_ * pull.z();
    if (bounded) pull.head<2>() *= tilt_ * pull.z() / level;
    if (!bounded) sum_ += error * tick.period;  // no windup

    const Mat3 r = pose.q.toRotationMatrix();
    Mat3 d;
    d.col(2) = pull.normalized();
    d.col(1) = d.col(2).cross(Vec3(std::cos(heading_), std::sin(heading_), 0)).normalized();
    d.col(0) = d.col(1).cross(d.col(2));
    const Mat3 skew = 0.5 * (d.transpose() * r - r.transpose() * d);
    const Vec3 off(skew(2, 1), skew(0, 2), skew(1, 0));
    const Vec3 turning = r.transpose() * twist.angular;
    const Vec3 torque = inertia_.cwiseProduct(-fast_ * fast_ * off - 2 * fast_ * turning);
    const double thrust = mass_ * pull.dot(r.col(2));

    const double share = 1 - std::exp(-tick.period / lag_);
    for (std::size_t i = 0; i < 4; ++i) {
      const double level_i = thrust / 4 + (kY[i] * torque.x() - kX[i] * torque.y()) / (4 * arm_) +
                             kSpin[i] * torque.z() / (4 * yaw_per_thrust_);
      thrusts_[i] += share * (std::clamp(level_i, 0.0, strongest_) - thrusts_[i]);
      robot_->publish(kOutputs[i], thrusts_[i]);
    }
    robot_->publish("error", error.norm());
  }

 private:
  /// Moves the reference towards the next waypoint; its velocity.
  Vec3 follow(double period) {
    if (next_ >= waypoints_.size()) return Vec3::Zero();
    const Vec3 to_waypoint = waypoints_[next_] - reference_;
    const double step = speed_ * period;
    if (to_waypoint.norm() <= step) {
      reference_ = waypoints_[next_++];
      return Vec3::Zero();
    }
    reference_ += to_waypoint.normalized() * step;
    return to_waypoint.normalized() * speed_;
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::PoseSensor tracker_;
  double mass_ = 0.0, arm_ = 0.0, yaw_per_thrust_ = 0.0, strongest_ = 0.0, lag_ = 0.0;
  double gravity_ = 0.0, speed_ = 0.0, heading_ = 0.0, slow_ = 0.0, fast_ = 0.0, tilt_ = 0.0;
  Vec3 inertia_ = Vec3::Zero(), reference_ = Vec3::Zero(), sum_ = Vec3::Zero();
  std::vector<Vec3> waypoints_;
  std::size_t next_ = 0;
  bool started_ = false;
  std::array<double, 4> thrusts_{};  // [N]
};

}  // namespace
}  // namespace quadrotor_pilot

COGRSIM_CONTROLLER(
    quadrotor_pilot::QuadrotorPilot, "quadrotor_pilot", version("1.0.0"), author("CogRSim"),
    summary("flies a quadrotor along waypoints, and holds the last one"),
    parameter("pose", "tracker", "name of a pose sensor at the centre of mass"),
    parameter("waypoints", std::vector<double>{}, "m", "positions x y z, x y z …").must_be_set(),
    parameter("speed", 1.0, "m/s", "along the waypoints").range(1e-3, 100.0),
    parameter("heading", 0.0, "rad", "of the body's x axis").range(-7.0, 7.0),
    parameter("mass", 0.65, "kg", "of everything").range(1e-3, 1e3).must_be_set(),
    parameter("inertia", std::vector<double>{}, "kg*m^2", "about x, y and z").must_be_set(),
    parameter("arm", 0.09, "m", "distance of each rotor from the centre along x, and along y")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("yaw_per_thrust", 0.012, "m", "torque of a rotor about z per thrust")
        .range(1e-6, 10.0)
        .must_be_set(),
    parameter("max_thrust", 4.0, "N", "of each rotor").range(1e-3, 1e5).must_be_set(),
    parameter("rotor_lag", 0.03, "s", "time constant of the rotors").range(1e-4, 10.0),
    parameter("gravity", 9.81, "m/s^2", "acceleration of free fall").range(0.0, 100.0),
    parameter("position_rate", 2.0, "rad/s", "of the position loop, three equal poles")
        .range(0.01, 100.0),
    parameter("attitude_rate", 14.0, "rad/s", "of the attitude loop").range(0.1, 1000.0),
    parameter("max_tilt", 0.6, "rad", "of the wanted thrust").range(0.0, 1.5),
    output("rotor_1", "N", "thrust front left"), output("rotor_2", "N", "thrust front right"),
    output("rotor_3", "N", "thrust rear right"), output("rotor_4", "N", "thrust rear left"),
    output("error", "m", "distance from the moving reference"))
