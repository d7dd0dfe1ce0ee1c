// A controller: drives a two-wheel robot in waves.
#include <algorithm>
#include <cmath>

#include <cogrsim/control/controller.h>

class Slalom final : public cogrsim::Controller {
 public:
  // Once, before the run. What is asked for and not there makes the load fail with a list of what
  // there is, so nothing needs to be checked here.
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("left");
    right_ = robot.motor("right");
    radius_ = robot.parameter<double>("wheel_radius");
    track_ = robot.parameter<double>("track");
    speed_ = robot.parameter<double>("speed");
    swing_ = robot.parameter<double>("swing");
    period_ = robot.parameter<double>("period");
  }

  // At the rate that the scene gives.
  void update(const cogrsim::Tick& tick) override {
    // The heading swings as swing * sin(w t), so the turn rate is its derivative. Over the first
    // wave everything grows from zero: wheels that jump to their speed would slip.
    const double w = 2 * 3.14159265358979323846 / period_;
    const double grown = std::min(1.0, tick.time / period_);
    const double speed = grown * speed_;
    const double turn_rate = grown * swing_ * w * std::cos(w * tick.time);
    left_.set((speed - turn_rate * track_ / 2) / radius_);
    right_.set((speed + turn_rate * track_ / 2) / radius_);
  }

 private:
  cogrsim::MotorHandle left_, right_;
  double radius_ = 0, track_ = 0;  // [m]
  double speed_ = 0;               // [m/s]
  double swing_ = 0;               // [rad]
  double period_ = 0;              // [s]
};

COGRSIM_CONTROLLER(Slalom, "slalom", version("1.0.0"), author("you"),
                   summary("drives two wheels in waves"),
                   parameter("wheel_radius", 0.05, "m", "radius of the wheels").range(0.001, 1.0),
                   parameter("track", 0.18, "m", "distance between the wheels").range(0.001, 5.0),
                   parameter("speed", 0.3, "m/s", "along the path").range(0.0, 2.0),
                   parameter("swing", 0.7, "rad", "largest heading to either side").range(0.0, 1.5),
                   parameter("period", 2.0, "s", "of one wave").range(0.1, 60.0))
