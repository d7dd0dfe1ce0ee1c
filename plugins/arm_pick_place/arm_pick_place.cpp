// Lets an arm of six axes take an object with a gripper of two fingers, and put it down elsewhere.
// The arm's axes are, from the base: z, y, y, z, y, z; with all angles 0 it stands upright:
//
//     X(q) = Rz(q1) Tz(shoulder) Ry(q2) Tz(upper) Ry(q3) Tz(fore) Rz(q4) Ry(q5) Tz(hand) Rz(q6)
//
// The tool moves on straight lines with the least jerk, s(t) = 10 t^3 - 15 t^4 + 6 t^5, pointing down.
// Angles for its pose come from damped least squares (Y. Nakamura, H. Hanafusa, 1986), from the angles
// before: with the error e of position and rotation and the Jacobian J,
//
//     dq = J^T (J J^T + d^2 I)^-1 e
//
// The fingers hold by friction: they are servos whose targets lie `squeeze` inside of the object.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/constants.h"

namespace arm_pick_place {
namespace {

using cogrsim::Mat3;
using cogrsim::Vec3;
using Joints = Eigen::Matrix<double, 6, 1>;

struct Geometry {
  double shoulder = 0.0, upper = 0.0, fore = 0.0, hand = 0.0;  // [m]
};

struct Posture {
  Vec3 p;                             // of the tool, in the frame of the base [m]
  Mat3 r;                             // of the tool
  Eigen::Matrix<double, 6, 6> slope;  // of position and rotation by the angles
};

Posture posture(const Geometry& g, const Joints& q) {
  const std::array<double, 6> before = {0.0, g.shoulder, g.upper, g.fore, 0.0, g.hand};
  std::array<Vec3, 6> origins, axes;
  Posture out;
  out.p.setZero();
  out.r.setIdentity();
  for (std::size_t i = 0; i < 6; ++i) {
    out.p += out.r * Vec3(0, 0, before[i]);
    const Vec3 axis = i == 1 || i == 2 || i == 4 ? Vec3::UnitY() : Vec3::UnitZ();
    origins[i] = out.p;
    axes[i] = out.r * axis;
    out.r = out.r * Eigen::AngleAxisd(q[static_cast<Eigen::Index>(i)], axis).toRotationMatrix();
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    out.slope.block<3, 1>(0, column) = axes[i].cross(out.p - origins[i]);
    out.slope.block<3, 1>(3, column) = axes[i];
  }
  return out;
}

/// Angles near `q` that bring the tool to `p`, `r`; false: after 50 steps they are not there.
bool solve(const Geometry& g, const Vec3& p, const Mat3& r, Joints& q) {
  constexpr double kDamping = 0.02;
  for (int i = 0; i < 50; ++i) {
    const Posture now = posture(g, q);
    const Eigen::AngleAxisd turn(r * now.r.transpose());
    Joints e;
    e << p - now.p, turn.angle() * turn.axis();
    if (e.norm() < 1e-6) return true;
    e *= std::min(1.0, 0.3 / e.norm());  // within what the slope describes
    const Eigen::Matrix<double, 6, 6> square =
        now.slope * now.slope.transpose() +
        kDamping * kDamping * Eigen::Matrix<double, 6, 6>::Identity();
    q += now.slope.transpose() * square.ldlt().solve(e);
  }
  return false;
}

struct Move {
  Vec3 to;               // of the tool [m]
  double yaw = 0.0;      // [rad]
  double opening = 0.0;  // of each finger [m]
  double pause = 0.0;    // afterwards [s]
};

class ArmPickPlace final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    std::istringstream names(robot.parameter<std::string>("motors"));
    for (std::string name; names >> name;) motors_.push_back(robot.motor(name));
    if (motors_.size() != 6)
      robot.fail("parameter 'motors': expected 6 names, from the base on, found " +
                 std::to_string(motors_.size()));
    std::istringstream fingers(robot.parameter<std::string>("fingers"));
    for (std::string name; fingers >> name;) fingers_.push_back(robot.motor(name));
    geometry_ = {robot.parameter<double>("shoulder"), robot.parameter<double>("upper"),
                 robot.parameter<double>("fore"), robot.parameter<double>("hand")};
    speed_ = robot.parameter<double>("speed");
    const Vec3 pick = point(robot, "pick"), place = point(robot, "place");
    const double pick_yaw = robot.parameter<double>("pick_yaw");
    const double place_yaw = robot.parameter<double>("place_yaw");
    const double open = robot.parameter<double>("open");
    const double hold = robot.parameter<double>("width") / 2 - robot.parameter<double>("squeeze");
    const Vec3 lift(0, 0, robot.parameter<double>("lift"));
    const double wait = robot.parameter<double>("pause");
    moves_ = {{pick + lift, pick_yaw, open, 0.0},   {pick, pick_yaw, open, 0.1},
              {pick, pick_yaw, hold, wait},         {pick + lift, pick_yaw, hold, 0.0},
              {place + lift, place_yaw, hold, 0.0}, {place, place_yaw, hold, 0.1},
              {place, place_yaw, open, wait},       {place + lift, place_yaw, open, 0.0}};
    robot.publish("phase", 0.0);
    robot.publish("done", 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (next_ == 0) {
      for (std::size_t i = 0; i < 6; ++i)
        q_[static_cast<Eigen::Index>(i)] = robot_->joint_position(motors_[i]);
      const Posture here = posture(geometry_, q_);
      from_ = {here.p, std::atan2(here.r(1, 1), here.r(0, 1)) - cogrsim::kPi / 2, 0.0, 0.0};
      start_move(tick.time);
    }
    const Move& to = moves_[next_ - 1];
    const double t = duration_ > 0 ? std::min((tick.time - begin_) / duration_, 1.0) : 1.0;
    const double s = t * t * t * (10 + t * (6 * t - 15));
    const Vec3 p = from_.to + s * (to.to - from_.to);
    const double yaw = from_.yaw + s * (to.yaw - from_.yaw);
    const Mat3 r =
        (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(cogrsim::kPi, Vec3::UnitY()))
            .toRotationMatrix();
    Joints q = q_;
    if (!solve(geometry_, p, r, q) && !warned_) {
      robot_->report("arm_pick_place: a point is out of reach");
      warned_ = true;
    }
    q_ = q;
    for (std::size_t i = 0; i < 6; ++i) motors_[i].set(q_[static_cast<Eigen::Index>(i)]);
    for (cogrsim::MotorHandle& finger : fingers_) finger.set(to.opening);
    robot_->publish("phase", static_cast<double>(next_));
    if (tick.time < begin_ + duration_ + to.pause) return;
    if (next_ < moves_.size()) {
      from_ = to;
      start_move(tick.time);
    } else {
      robot_->publish("done", 1.0);
    }
  }

 private:
  static Vec3 point(cogrsim::Assembly& robot, const std::string& name) {
    const auto xyz = robot.parameter<std::vector<double>>(name);
    if (xyz.size() == 3) return {xyz[0], xyz[1], xyz[2]};
    robot.fail("parameter '" + name + "': expected x y z in the frame of the base");
    return Vec3::Zero();
  }

  void start_move(double time) {
    const Move& to = moves_[next_++];
    begin_ = time;
    // The fastest point of the motion is 15/8 of its mean.
    const double path_length =
        std::max((to.to - from_.to).norm(), 0.15 * std::abs(to.yaw - from_.yaw));
    duration_ = 15.0 / 8.0 * path_length / speed_;
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  std::vector<cogrsim::MotorHandle> motors_, fingers_;
  Geometry geometry_;
  Joints q_ = Joints::Zero();
  std::vector<Move> moves_;
  Move from_;
  std::size_t next_ = 0;  // the current move, counted from 1
  double begin_ = 0.0, duration_ = 0.0, speed_ = 0.0;
  bool warned_ = false;
};

}  // namespace
}  // namespace arm_pick_place

COGRSIM_CONTROLLER(
    arm_pick_place::ArmPickPlace, "arm_pick_place", version("1.0.0"), author("CogRSim"),
    summary("an arm of six axes takes an object with two fingers and puts it down elsewhere"),
    parameter("motors", "m1 m2 m3 m4 m5 m6", "motors of the axes from the base on, mode position"),
    parameter("fingers", "grip_left grip_right", "servos of the fingers, 0 closed"),
    parameter("shoulder", 0.3, "m", "height of the second axis").range(0.0, 100.0).must_be_set(),
    parameter("upper", 0.35, "m", "from the second to the third axis")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("fore", 0.3, "m", "from the third axis to the wrist")
        .range(1e-3, 100.0)
        .must_be_set(),
    parameter("hand", 0.18, "m", "from the wrist to the point between the fingertips")
        .range(0.0, 100.0)
        .must_be_set(),
    parameter("pick", std::vector<double>{}, "m", "x y z of the object, in the frame of the base")
        .must_be_set(),
    parameter("place", std::vector<double>{}, "m", "x y z of its new place").must_be_set(),
    parameter("pick_yaw", 0.0, "rad", "of the hand; the fingers close along its y axis")
        .range(-7.0, 7.0),
    parameter("place_yaw", 0.0, "rad", "of the hand where it puts the object down")
        .range(-7.0, 7.0),
    parameter("width", 0.04, "m", "of the object between the fingers").range(0.0, 1.0),
    parameter("squeeze", 0.008, "m", "by which the fingers' targets lie inside of the object")
        .range(0.0, 1.0),
    parameter("open", 0.035, "m", "of each finger").range(0.0, 1.0),
    parameter("lift", 0.15, "m", "height above object and place").range(0.0, 10.0),
    parameter("pause", 0.4, "s", "for closing and opening").range(0.0, 100.0),
    parameter("speed", 0.5, "m/s", "of the tool").range(1e-3, 10.0),
    output("phase", "1",
           "1 above the object, 2 at it, 3 closing, 4 lifting, 5 above the place, 6 "
           "at it, 7 opening, 8 leaving"),
    output("done", "1", "1 at the end"))
