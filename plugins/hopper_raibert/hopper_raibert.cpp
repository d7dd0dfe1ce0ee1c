// Lets a robot with one springy leg hop in a plane by three independent laws (M. Raibert, Legged Robots
// that Balance, 1986). With the trunk's pitch a, the leg's angle b from the vertical, the last stance's
// duration T and the forward speed v, wanted w:
//
//     height     while the spring extends, the leg pushes with the force f; after each apex h
//                f += c (h_wanted - h)
//     speed      in flight the leg swings to the point x = v T/2 + k (v - w) in front of the hip:
//                b = -asin(x / length), torque kp (b - b_measured) - kd b'
//     attitude   in stance the hip levels the trunk: torque p a + d a'
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "cogrsim/control/controller.h"

namespace hopper_raibert {
namespace {

class HopperRaibert final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    hip_ = robot.motor(robot.parameter<std::string>("hip"), cogrsim::MotorMode::torque);
    leg_ = robot.motor(robot.parameter<std::string>("leg"), cogrsim::MotorMode::torque);
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    foot_ = robot.sensor<cogrsim::ContactSensor>(robot.parameter<std::string>("foot"));
    length_ = robot.parameter<double>("length");
    wanted_ = robot.parameter<double>("speed");
    height_ = robot.parameter<double>("height");
    push_ = robot.parameter<double>("push");
    push_gain_ = robot.parameter<double>("push_gain");
    speed_gain_ = robot.parameter<double>("speed_gain");
    swing_p_ = robot.parameter<double>("swing_kp");
    swing_d_ = robot.parameter<double>("swing_kd");
    level_p_ = robot.parameter<double>("level_kp");
    level_d_ = robot.parameter<double>("level_kd");
    duration_ = robot.parameter<double>("stance");
    for (const char* name : {"hops", "apex", "stance", "pitch"}) robot.publish(name, 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid() || !foot_.valid()) return;
    const cogrsim::Pose pose = tracker_.pose();
    const cogrsim::Twist twist = tracker_.twist();
    const cogrsim::Vec3 ahead = pose.q * cogrsim::Vec3::UnitX();
    const double pitch = std::atan2(-ahead.z(), ahead.x()), pitch_rate = twist.angular.y();
    const double angle = pitch + robot_->joint_position(hip_);
    const double rate = pitch_rate + robot_->joint_velocity(hip_);
    // Coordinate of the leg: 0 where its spring is relaxed, below 0 compressed.
    const double travel = robot_->joint_position(leg_), stretch = robot_->joint_velocity(leg_);

    // A foot chatters when it lands: neither stance nor flight is shorter than kShortest.
    const bool was = stands_;
    if (tick.time - changed_ > kShortest)
      stands_ = was ? travel < -kTouch : foot_.touching() && travel < -kTouch;
    if (stands_ != was) {
      if (was) {
        duration_ = tick.time - changed_;
        robot_->publish("hops", static_cast<double>(++hops_));
      }
      changed_ = tick.time;
    }
    const double rise = twist.linear.z();
    if (!stands_ && last_rise_ > 0.0 && rise <= 0.0 && hops_ > 0) {
      push_ = std::clamp(push_ + push_gain_ * (height_ - pose.p.z()), 0.0, leg_.max_effort());
      robot_->publish("apex", pose.p.z());
    }
    last_rise_ = rise;

    if (stands_) {
      hip_.set(level_p_ * pitch + level_d_ * pitch_rate);
      leg_.set(stretch > 0.0 ? push_ : 0.0);
    } else {
      const double speed = twist.linear.x();
      const double x = speed * duration_ / 2 + speed_gain_ * (speed - wanted_);
      const double goal = -std::asin(std::clamp(x / length_, -0.5, 0.5));
      hip_.set(swing_p_ * (goal - angle) - swing_d_ * rate);
      leg_.set(0.0);
    }
    robot_->publish("stance", stands_ ? 1.0 : 0.0);
    robot_->publish("pitch", pitch);
  }

 private:
  static constexpr double kTouch = 2e-3;     // [m] that a leg in stance is compressed, at least
  static constexpr double kShortest = 0.06;  // [s]

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::MotorHandle hip_, leg_;
  cogrsim::PoseSensor tracker_;
  cogrsim::ContactSensor foot_;
  double length_ = 0.0, wanted_ = 0.0, height_ = 0.0;
  double push_ = 0.0, push_gain_ = 0.0, speed_gain_ = 0.0;
  double swing_p_ = 0.0, swing_d_ = 0.0, level_p_ = 0.0, level_d_ = 0.0;
  double duration_ = 0.0, changed_ = 0.0, last_rise_ = 0.0;
  bool stands_ = false;
  int hops_ = 0;
};

}  // namespace
}  // namespace hopper_raibert

COGRSIM_CONTROLLER(
    hopper_raibert::HopperRaibert, "hopper_raibert", version("1.0.0"), author("CogRSim"),
    summary("lets a robot with one springy leg hop in a plane"),
    parameter("hip", "hip", "motor between trunk and leg, mode torque"),
    parameter("leg", "leg", "motor along the leg, mode torque; 0 where its spring is relaxed"),
    parameter("pose", "tracker", "name of a pose sensor at the hip"),
    parameter("foot", "touch", "name of a contact sensor on the foot"),
    parameter("length", 0.6, "m", "of the relaxed leg").range(1e-3, 100.0).must_be_set(),
    parameter("speed", 0.8, "m/s", "forward").range(-10.0, 10.0),
    parameter("height", 0.85, "m", "of the hip at the apex").range(0.0, 100.0).must_be_set(),
    parameter("push", 120.0, "N", "force of the leg at the first hop").range(0.0, 1e6),
    parameter("push_gain", 300.0, "force per height that an apex lacks [N/m]").range(0.0, 1e6),
    parameter("speed_gain", 0.05, "s", "of the foot's position, per error of speed")
        .range(0.0, 10.0),
    parameter("swing_kp", 60.0, "torque per angle of the leg in flight [N m/rad]").range(0.0, 1e6),
    parameter("swing_kd", 3.0, "torque per its rate [N m s/rad]").range(0.0, 1e6),
    parameter("level_kp", 250.0, "torque per pitch in stance [N m/rad]").range(0.0, 1e6),
    parameter("level_kd", 25.0, "torque per its rate [N m s/rad]").range(0.0, 1e6),
    parameter("stance", 0.15, "s", "expected duration of the first stance").range(1e-3, 10.0),
    output("hops", "1", "number of take-offs"),
    output("apex", "m", "height of the hip at the last apex"),
    output("stance", "1", "1 in stance, 0 in flight"), output("pitch", "rad", "of the trunk"))
