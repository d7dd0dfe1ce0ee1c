// @NAME@: drives a robot with two wheels towards what is in front of it and stops at a distance.
//
// A controller sees the world through sensors and acts through motors. It is asked once for what it
// needs (configure), and then again and again for what to do next (update).
#include <algorithm>
#include <cmath>

#include <cogrsim/control/controller.h>

namespace {

class @CLASS@ final : public cogrsim::Controller {
 public:
  // Once, before the run. What is asked for and not there makes the load fail, with a list of what
  // there is, so nothing needs to be checked here.
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("left");
    right_ = robot.motor("right");
    ahead_ = robot.sensor<cogrsim::Infrared>("ahead");
    wheel_radius_ = robot.parameter<double>("wheel_radius");
    speed_ = robot.parameter<double>("speed");
    gap_ = robot.parameter<double>("gap");
  }

  // At the rate that the scene gives. tick.time is that of what the sensors have read.
  void update(const cogrsim::Tick& tick) override {
    const double wanted = wanted_speed();
    // A wheel that jumps to its speed slips, so the speed grows step by step. Time comes from the
    // tick, never from the clock on the wall: a run must repeat.
    const double change = kAcceleration * tick.period;
    now_ = std::clamp(wanted, now_ - change, now_ + change);
    // Motors of mode "velocity" aim at an angular speed [rad/s]. They hold it until told otherwise.
    left_.set(now_ / wheel_radius_);
    right_.set(now_ / wheel_radius_);
  }

 private:
  // Along the robot's x axis [m/s].
  double wanted_speed() const {
    // Before the first reading and after a dropout there is no distance: better stand.
    if (!ahead_.valid()) return 0.0;
    // +infinity means that nothing is in sight, -infinity that something is too near to tell how
    // near. Both do the right thing below.
    const double too_far = ahead_.distance() - gap_;
    // Proportional control: with speed = kGain * distance left, what is left halves every
    // ln 2 / kGain = 0.35 s, and is never overshot.
    return std::clamp(kGain * too_far, -speed_, speed_);
  }

  static constexpr double kGain = 2.0;          // [1/s]
  static constexpr double kAcceleration = 1.0;  // [m/s^2]

  cogrsim::MotorHandle left_, right_;
  cogrsim::Infrared ahead_;
  double wheel_radius_ = 0.0;  // [m]
  double speed_ = 0.0;         // [m/s]
  double gap_ = 0.0;           // [m]
  double now_ = 0.0;           // speed asked for at present [m/s]
};

}  // namespace

// Name, unit, default and range are checked where the scene sets them: <set gap="20 cm"/>.
COGRSIM_CONTROLLER(@CLASS@, "@NAME@", version("0.1.0"), author("you"),
                   summary("drives forward and stops at a distance"),
                   parameter("wheel_radius", 0.05, "m", "radius of the wheels").range(0.005, 1.0),
                   parameter("speed", 0.3, "m/s", "at most").range(0.01, 2.0),
                   parameter("gap", 0.2, "m", "distance at which it stops").range(0.06, 0.7))
