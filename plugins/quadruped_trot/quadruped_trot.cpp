// Lets a robot with four legs of three joints trot: two diagonal legs stand while the others swing.
// For a foot at (x, y, z) from its hip's roll axis, with the leg's plane at d to the side, thigh a and
// shank b, the angles are (knees point backwards)
//
//     l = sqrt(y^2 + z^2 - d^2)           roll  = atan2(z, y) - atan2(-l, d)
//     cos(knee) = (x^2 + l^2 - a^2 - b^2) / (2 a b),   knee < 0
//     pitch = atan2(-x, l) - atan2(b sin(knee), a + b cos(knee))
//
// Seen from the trunk a standing foot moves with -(v + w x p). A swinging one is lifted and lands where
// the leg will stand upright half a stance later, further out if the trunk is too fast (M. Raibert,
// Legged Robots that Balance, 1986):
//
//     p = hip + v T/4 + k (v_measured - v)        T: a whole stride
//
// where v is the speed asked for and 1.5/s times what the trunk is behind of a point with that speed.
// Each joint's torque is kp (angle - q) - kd q'. Standing legs level the trunk: each is longer by
// (c a + c' a') times its distance from the axis of the angle a, pitch or roll.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"
#include "cogrsim/core/constants.h"

namespace quadruped_trot {
namespace {

using cogrsim::Mat3;
using cogrsim::Vec3;

// The trunk follows a point that moves with the speed: it catches up with this rate [1/s] ...
constexpr double kCatchUp = 1.5;
// ... what it is behind, along x and y, up to this [m].
constexpr double kMostBehind = 0.15;

struct Leg {
  std::array<cogrsim::MotorHandle, 3> motors;  // roll, pitch, knee
  Vec3 hip = Vec3::Zero();                     // its roll axis in the trunk [m]
  double side = 1.0;                           // 1 left, -1 right
  double phase = 0.0;                          // of a stride
  Vec3 foot = Vec3::Zero();                    // target, from the trunk's origin, level axes [m]
  Vec3 lifted = Vec3::Zero();                  // where the swing began
  bool swings = false;
};

class QuadrupedTrot final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    offset_ = robot.parameter<double>("offset");
    thigh_ = robot.parameter<double>("thigh");
    shank_ = robot.parameter<double>("shank");
    height_ = robot.parameter<double>("height");
    speed_ = Vec3(robot.parameter<double>("speed"), robot.parameter<double>("sideways_speed"), 0);
    turn_ = robot.parameter<double>("turn_rate");
    stride_ = robot.parameter<double>("stride");
    lift_ = robot.parameter<double>("lift");
    stand_ = robot.parameter<double>("stand");
    capture_ = robot.parameter<double>("capture_gain");
    kp_ = robot.parameter<double>("kp");
    kd_ = robot.parameter<double>("kd");
    level_ = robot.parameter<double>("level_gain");
    level_rate_ = robot.parameter<double>("level_rate_gain");
    const double x = robot.parameter<double>("hip_x"), y = robot.parameter<double>("hip_y");
    robot.publish("roll", 0.0);
    robot.publish("pitch", 0.0);
    const std::array<std::string, 4> names = {"front_left", "front_right", "rear_left",
                                              "rear_right"};
    for (std::size_t i = 0; i < 4; ++i) {
      Leg& leg = legs_[i];
      leg.side = i % 2 == 0 ? 1.0 : -1.0;
      leg.hip = Vec3(i < 2 ? x : -x, leg.side * y, 0);
      leg.phase = i == 0 || i == 3 ? 0.0 : 0.5;
      leg.foot = stance(leg);
      for (std::size_t k = 0; k < 3; ++k)
        leg.motors[k] = robot.motor(names[i] + (k == 0   ? "_roll"
                                                : k == 1 ? "_pitch"
                                                         : "_knee"),
                                    cogrsim::MotorMode::torque);
    }
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid()) return;
    const cogrsim::Pose pose = tracker_.pose();
    const cogrsim::Twist twist = tracker_.twist();
    const Mat3 r = pose.q.toRotationMatrix();
    const double heading = cogrsim::planar(pose).heading;
    // The trunk in level axes that turn with its heading.
    const Mat3 level = Eigen::AngleAxisd(heading, Vec3::UnitZ()).toRotationMatrix().transpose();
    const Mat3 tilted = level * r;
    const Vec3 speed = level * twist.linear, turning = level * twist.angular;
    const double roll = std::atan2(tilted(2, 1), tilted(2, 2)), pitch = -std::asin(tilted(2, 0));
    if (!started_) heading_ = heading;

    const double time = tick.time - stand_;
    const bool walks = time >= 0.0;
    // It gathers speed over two strides.
    const double share = walks ? std::min(time / (2 * stride_), 1.0) : 0.0;
    const double ahead = heading_;
    heading_ += share * turn_ * tick.period;
    if (!started_) path_ = pose.p;
    started_ = true;
    path_ += share * tick.period * (Eigen::AngleAxisd(ahead, Vec3::UnitZ()) * speed_);
    Vec3 behind = level * (path_ - pose.p);
    behind.z() = 0.0;
    const Vec3 wanted =
        share * (speed_ + behind.cwiseMax(-kMostBehind).cwiseMin(kMostBehind) * kCatchUp);
    const double turn =
        share * turn_ + 2.0 * std::clamp(cogrsim::wrapped_angle(heading_ - heading), -0.3, 0.3);
    const Vec3 spin(0, 0, walks ? turn : 0.0);

    for (Leg& leg : legs_) {
      const double phase = walks ? std::fmod(time / stride_ + leg.phase, 1.0) : 0.6;
      const bool swings = phase < 0.5;
      if (swings && !leg.swings) leg.lifted = leg.foot;
      leg.swings = swings;
      Vec3 foot;
      if (swings) {
        const double t = 2.0 * phase, s = t * t * (3 - 2 * t);
        Vec3 land = stance(leg);
        const Vec3 middle = land;
        land += (wanted + spin.cross(middle)) * stride_ / 4;
        Vec3 more = capture_ * (speed - wanted);
        more.z() = 0.0;
        land += more.cwiseMax(-0.08).cwiseMin(0.08);
        leg.foot = leg.lifted + s * (land - leg.lifted);
        foot = leg.foot;
        foot.z() += lift_ * std::sin(cogrsim::kPi * t);
        foot = tilted.transpose() * foot;
      } else {
        leg.foot -= (wanted + spin.cross(leg.foot)) * tick.period;
        leg.foot.z() += std::min(1.0, 20 * tick.period) * (-height_ - leg.foot.z());
        foot = leg.foot;
        foot.z() += leg.hip.y() * (level_ * roll + level_rate_ * turning.x()) -
                    leg.hip.x() * (level_ * pitch + level_rate_ * turning.y());
      }
      command(leg, foot - leg.hip);
    }
    robot_->publish("roll", roll);
    robot_->publish("pitch", pitch);
  }

 private:
  Vec3 stance(const Leg& leg) const { return leg.hip + Vec3(0, leg.side * offset_, -height_); }

  void command(Leg& leg, Vec3 p) const {
    const double longest = 0.995 * (thigh_ + shank_), d = leg.side * offset_;
    const double l = std::sqrt(std::max(p.y() * p.y() + p.z() * p.z() - d * d, 1e-6));
    const double reach = std::hypot(p.x(), l);
    const double shrink = std::min(1.0, longest / reach);
    const double x = p.x() * shrink, in_plane = l * shrink;
    const double roll = std::atan2(p.z(), p.y()) - std::atan2(-l, d);
    const double cosine =
        (x * x + in_plane * in_plane - thigh_ * thigh_ - shank_ * shank_) / (2 * thigh_ * shank_);
    const double knee = -std::acos(std::clamp(cosine, -1.0, 1.0));
    const double pitch = std::atan2(-x, in_plane) -
                         std::atan2(shank_ * std::sin(knee), thigh_ + shank_ * std::cos(knee));
    const std::array<double, 3> angles = {cogrsim::wrapped_angle(roll), pitch, knee};
    for (std::size_t i = 0; i < 3; ++i)
      leg.motors[i].set(kp_ * (angles[i] - robot_->joint_position(leg.motors[i])) -
                        kd_ * robot_->joint_velocity(leg.motors[i]));
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::PoseSensor tracker_;
  std::array<Leg, 4> legs_;
  double offset_ = 0.0, thigh_ = 0.0, shank_ = 0.0, height_ = 0.0;
  double turn_ = 0.0, stride_ = 0.0, lift_ = 0.0, stand_ = 0.0;
  double capture_ = 0.0, level_ = 0.0, level_rate_ = 0.0, heading_ = 0.0;
  double kp_ = 0.0, kd_ = 0.0;
  bool started_ = false;
  Vec3 path_ = Vec3::Zero();  // where the trunk should be [m]
  Vec3 speed_ = Vec3::Zero();
};

}  // namespace
}  // namespace quadruped_trot

COGRSIM_CONTROLLER(
    quadruped_trot::QuadrupedTrot, "quadruped_trot", version("1.0.0"), author("CogRSim"),
    summary("lets a robot with four legs of three joints trot"),
    parameter("pose", "tracker", "name of a pose sensor at the middle of the trunk"),
    parameter("hip_x", 0.19, "m", "of the front hips' roll axes; the rear ones at minus that")
        .range(1e-3, 10.0)
        .must_be_set(),
    parameter("hip_y", 0.06, "m", "of the left hips' roll axes").range(0.0, 10.0).must_be_set(),
    parameter("offset", 0.05, "m", "of a leg's plane from its roll axis")
        .range(0.0, 10.0)
        .must_be_set(),
    parameter("thigh", 0.2, "m", "length").range(1e-3, 10.0).must_be_set(),
    parameter("shank", 0.2, "m", "length, to the middle of the foot")
        .range(1e-3, 10.0)
        .must_be_set(),
    parameter("height", 0.3, "m", "of the hips above the feet's middles")
        .range(1e-3, 10.0)
        .must_be_set(),
    parameter("speed", 0.4, "m/s", "forward").range(-5.0, 5.0),
    parameter("sideways_speed", 0.0, "m/s", "to the left").range(-5.0, 5.0),
    parameter("turn_rate", 0.0, "rad/s", "to the left").range(-10.0, 10.0),
    parameter("stride", 0.4, "s", "time of a whole stride").range(0.05, 10.0),
    parameter("lift", 0.06, "m", "of a swinging foot").range(0.0, 1.0),
    parameter("stand", 0.3, "s", "time before the first step").range(0.0, 1e6),
    parameter("kp", 100.0, "torque per error of an angle [N m/rad]").range(0.0, 1e6),
    parameter("kd", 1.5, "torque per rate of an angle [N m s/rad]").range(0.0, 1e6),
    parameter("capture_gain", 0.1, "s", "further out per speed that is too fast").range(0.0, 10.0),
    parameter("level_gain", 0.6, "length of a leg per tilt and distance").range(0.0, 10.0),
    parameter("level_rate_gain", 0.03, "s", "the same per rate of tilt").range(0.0, 10.0),
    output("roll", "rad", "of the trunk, in level axes"),
    output("pitch", "rad", "of the trunk, in level axes"))
