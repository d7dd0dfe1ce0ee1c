// Lets a robot with two legs of five joints walk with flat feet. All steps are planned before the first:
// the zero moment point p stands in the middle of each supporting foot and passes to the next one while
// both stand. The pelvis c, at the constant height h, moves so that a mass there puts it there (S. Kajita
// and others, Biped walking pattern generation, 2003), on a grid of times d apart:
//
//     p = c - h/g c'',   c'' = (c_(i-1) - 2 c_i + c_(i+1)) / d^2     a tridiagonal system
//
// A foot's joint is at (x, y, z) from its hip. With thigh a and shank b (knees point forwards),
//
//     roll = atan2(y, -z),  l = sqrt(y^2 + z^2)
//     cos(knee) = (x^2 + l^2 - a^2 - b^2) / (2 a b),   knee > 0
//     pitch = atan2(-x, l) - atan2(b sin(knee), a + b cos(knee))
//     ankle: -(pitch + knee) and -roll: the foot is level
//
// A supporting leg levels the pelvis with its hip, and with its ankle brings the pelvis back to c. Each
// joint's torque is kp (angle - q) - kd q'.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/control/controller.h"
#include "cogrsim/core/constants.h"

namespace biped_walk {
namespace {

using cogrsim::Vec3;

constexpr double kGrid = 0.005;  // [s]

/// The positions whose zero moment points are `p`, beginning and ending at rest there; `ratio` is h/g.
std::vector<double> pelvis_of(const std::vector<double>& p, double ratio) {
  const double off = -ratio / (kGrid * kGrid), middle = 1.0 - 2.0 * off;
  const std::size_t n = p.size();
  std::vector<double> factor(n, 0.0), out(p);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = middle - off * factor[i - 1];
    factor[i] = off / pivot;
    out[i] = (p[i] - off * out[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) out[i] -= factor[i] * out[i + 1];
  return out;
}

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

struct Step {
  double lifts = 0.0, lands = 0.0;  // [s]
  int foot = 0;                     // that swings: 0 left, 1 right
  double from = 0.0, to = 0.0;      // its x [m]
};

class BipedWalk final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;
    tracker_ = robot.sensor<cogrsim::PoseSensor>(robot.parameter<std::string>("pose"));
    const std::array<std::string, 2> sides = {"left_", "right_"};
    const std::array<std::string, 5> joints = {"hip_roll", "hip_pitch", "knee", "ankle_pitch",
                                               "ankle_roll"};
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t j = 0; j < 5; ++j) {
        motors_[s][j] = robot.motor(sides[s] + joints[j], cogrsim::MotorMode::torque);
      }
    }
    hip_ = robot.parameter<double>("hip_y");
    thigh_ = robot.parameter<double>("thigh");
    shank_ = robot.parameter<double>("shank");
    height_ = robot.parameter<double>("height");
    lift_ = robot.parameter<double>("lift");
    kp_ = robot.parameter<double>("kp");
    kd_ = robot.parameter<double>("kd");
    level_ = robot.parameter<double>("level_gain");
    back_ = robot.parameter<double>("return_gain");
    back_rate_ = robot.parameter<double>("return_rate_gain");
    plan(robot.parameter<int>("steps"), robot.parameter<double>("length"),
         robot.parameter<double>("swing"), robot.parameter<double>("support"),
         robot.parameter<double>("stand"), robot.parameter<double>("mass_height"));
    robot.publish("steps", 0.0);
    robot.publish("roll", 0.0);
    robot.publish("pitch", 0.0);
  }

  void update(const cogrsim::Tick& tick) override {
    if (!tracker_.valid()) return;
    const cogrsim::Pose pose = tracker_.pose();
    const cogrsim::Twist twist = tracker_.twist();
    if (!started_) start_ = pose.p;
    started_ = true;
    const cogrsim::Mat3 r = pose.q.toRotationMatrix();
    const double roll = std::atan2(r(2, 1), r(2, 2)), pitch = -std::asin(r(2, 0));

    const Vec3 wanted(at(x_, tick.time), at(y_, tick.time), 0.0);
    const Vec3 speed((at(x_, tick.time + kGrid) - wanted.x()) / kGrid,
                     (at(y_, tick.time + kGrid) - wanted.y()) / kGrid, 0.0);
    const Vec3 off = pose.p - start_ - wanted, off_rate = twist.linear - speed;
    std::array<Vec3, 2> feet = {Vec3(0, hip_, 0), Vec3(0, -hip_, 0)};
    std::array<bool, 2> swings = {false, false};
    int taken = 0;
    for (const Step& step : steps_) {
      const auto f = static_cast<std::size_t>(step.foot);
      const double t = (tick.time - step.lifts) / (step.lands - step.lifts);
      if (t <= 0.0) break;
      feet[f].x() = step.from + smooth(t) * (step.to - step.from);
      swings[f] = t < 1.0;
      feet[f].z() = t < 1.0 ? lift_ * std::pow(std::sin(cogrsim::kPi * t), 2) : 0.0;
      if (t >= 1.0) ++taken;
    }
    for (std::size_t s = 0; s < 2; ++s) {
      const Vec3 hip = wanted + Vec3(0, s == 0 ? hip_ : -hip_, height_);
      std::array<double, 5> q = angles(feet[s] - hip);
      if (swings[s]) {
        q[3] -= pitch;
        q[4] -= roll;
      } else {
        q[0] += level_ * roll;
        q[1] += level_ * pitch;
        q[3] += back_ * off.x() + back_rate_ * off_rate.x();
        q[4] -= back_ * off.y() + back_rate_ * off_rate.y();
      }
      for (std::size_t j = 0; j < 5; ++j) {
        // A foot weighs little: its two joints have softer gains.
        const double share = j < 3 ? 1.0 : 0.4;
        motors_[s][j].set(share * (kp_ * (q[j] - robot_->joint_position(motors_[s][j])) -
                                   kd_ * robot_->joint_velocity(motors_[s][j])));
      }
    }
    robot_->publish("steps", taken);
    robot_->publish("roll", roll);
    robot_->publish("pitch", pitch);
  }

 private:
  void plan(int steps, double length, double swing, double support, double stand, double mass) {
    // The zero moment point as corners (time, x, y), linear in between.
    std::vector<Vec3> corners = {{0, 0, 0}, {stand, 0, 0}};
    std::array<double, 2> x = {0.0, 0.0};
    double time = stand;
    for (int i = 0; i < steps; ++i) {
      const int foot = i % 2 == 0 ? 1 : 0;
      const auto f = static_cast<std::size_t>(foot), other = static_cast<std::size_t>(1 - foot);
      const double y = foot == 1 ? hip_ : -hip_;
      corners.emplace_back(time += support, x[other], y);
      const double to = i + 1 < steps ? x[other] + length : x[other];
      steps_.push_back({time, time + swing, foot, x[f], to});
      x[f] = to;
      corners.emplace_back(time += swing, x[other], y);
    }
    corners.emplace_back(time += 2 * support, (x[0] + x[1]) / 2, 0.0);
    corners.emplace_back(time += 1.0, (x[0] + x[1]) / 2, 0.0);
    std::vector<double> px, py;
    std::size_t k = 1;
    for (double t = 0.0; t < time; t += kGrid) {
      while (k + 1 < corners.size() && corners[k].x() < t) ++k;
      const Vec3 &a = corners[k - 1], &b = corners[k];
      const double s = b.x() > a.x() ? std::clamp((t - a.x()) / (b.x() - a.x()), 0.0, 1.0) : 1.0;
      px.push_back(a.y() + s * (b.y() - a.y()));
      py.push_back(a.z() + s * (b.z() - a.z()));
    }
    x_ = pelvis_of(px, mass / 9.81);
    y_ = pelvis_of(py, mass / 9.81);
  }

  static double at(const std::vector<double>& list, double time) {
    const double place = std::clamp(time / kGrid, 0.0, static_cast<double>(list.size() - 1));
    const auto i = static_cast<std::size_t>(place);
    if (i + 1 >= list.size()) return list.back();
    return list[i] + (place - static_cast<double>(i)) * (list[i + 1] - list[i]);
  }

  std::array<double, 5> angles(const Vec3& foot) const {
    const double roll = std::atan2(foot.y(), -foot.z()), l = std::hypot(foot.y(), foot.z());
    const double x = foot.x();
    const double cosine =
        (x * x + l * l - thigh_ * thigh_ - shank_ * shank_) / (2 * thigh_ * shank_);
    const double knee = std::acos(std::clamp(cosine, -1.0, 1.0));
    const double pitch =
        std::atan2(-x, l) - std::atan2(shank_ * std::sin(knee), thigh_ + shank_ * std::cos(knee));
    return {roll, pitch, knee, -(pitch + knee), -roll};
  }

  std::optional<cogrsim::Assembly> robot_;  // a copy, because that of configure() is destroyed
  cogrsim::PoseSensor tracker_;
  std::array<std::array<cogrsim::MotorHandle, 5>, 2> motors_;
  double hip_ = 0.0, thigh_ = 0.0, shank_ = 0.0, height_ = 0.0, lift_ = 0.0;
  double kp_ = 0.0, kd_ = 0.0, level_ = 0.0, back_ = 0.0, back_rate_ = 0.0;
  std::vector<Step> steps_;
  std::vector<double> x_, y_;  // of the pelvis, on the grid
  Vec3 start_ = Vec3::Zero();
  bool started_ = false;
};

}  // namespace
}  // namespace biped_walk

COGRSIM_CONTROLLER(
    biped_walk::BipedWalk, "biped_walk", version("1.0.0"), author("CogRSim"),
    summary("lets a robot with two legs of five joints walk with flat feet"),
    parameter("pose", "tracker", "name of a pose sensor between the hips"),
    parameter("hip_y", 0.07, "m", "of the left hip").range(1e-3, 10.0).must_be_set(),
    parameter("thigh", 0.25, "m", "length").range(1e-3, 10.0).must_be_set(),
    parameter("shank", 0.25, "m", "length").range(1e-3, 10.0).must_be_set(),
    parameter("height", 0.46, "m", "of the hips above the ankles").range(1e-3, 10.0).must_be_set(),
    parameter("mass_height", 0.55, "m", "of the centre of mass above the ground")
        .range(1e-3, 10.0)
        .must_be_set(),
    parameter("steps", 6, "number of steps; the last one only closes up").range(1, 1000),
    parameter("length", 0.1, "m", "from one foot to the other").range(0.0, 10.0),
    parameter("swing", 0.5, "s", "time on one foot").range(0.05, 10.0),
    parameter("support", 0.3, "s", "time on both feet before a step").range(0.05, 10.0),
    parameter("stand", 0.5, "s", "time before the first step").range(0.0, 1e3),
    parameter("lift", 0.04, "m", "of a swinging foot").range(0.0, 1.0),
    parameter("kp", 800.0, "torque per error of an angle [N m/rad]").range(0.0, 1e6),
    parameter("kd", 8.0, "torque per rate of an angle [N m s/rad]").range(0.0, 1e6),
    parameter("level_gain", 0.5, "angle of the hip per tilt of the pelvis").range(0.0, 10.0),
    parameter("return_gain", 1.0, "angle of the ankle per distance [rad/m]").range(0.0, 100.0),
    parameter("return_rate_gain", 0.2, "angle of the ankle per speed [rad s/m]").range(0.0, 100.0),
    output("steps", "1", "number of steps taken"), output("roll", "rad", "of the pelvis"),
    output("pitch", "rad", "of the pelvis"))
