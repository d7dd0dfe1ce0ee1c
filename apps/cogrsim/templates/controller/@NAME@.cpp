// @NAME@: drives a robot with two wheels towards an obstacle and stops at a distance.
//
// A controller reads sensors and commands motors. CogRSim calls configure() once, where it requests
// its devices, and then update() periodically, where it computes the next commands.
#include <algorithm>
#include <cmath>

#include <cogrsim/control/controller.h>

namespace {

class @CLASS@ final : public cogrsim::Controller {
 public:
  // Called once before the run. Requesting a device that does not exist makes loading fail with a
  // list of the existing ones, so nothing needs to be checked here.
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("left");
    right_ = robot.motor("right");
    ahead_ = robot.sensor<cogrsim::Infrared>("ahead");
    wheel_radius_ = robot.parameter<double>("wheel_radius");
    speed_ = robot.parameter<double>("speed");
    gap_ = robot.parameter<double>("gap");
  }

  // Called at the rate in the scene. tick.time is the time of the sensor readings.
  void update(const cogrsim::Tick& tick) override {
    const double wanted = wanted_speed();
    // A sudden speed would make the wheels slip, so the acceleration is limited. Use the time of
    // the tick and never wall-clock time: a run must be repeatable.
    const double change = kAcceleration * tick.period;
    now_ = std::clamp(wanted, now_ - change, now_ + change);
    // The target of a motor in mode "velocity" is an angular speed [rad/s], which it holds.
    left_.set(now_ / wheel_radius_);
    right_.set(now_ / wheel_radius_);
  }

 private:
  // Along the robot's x axis [m/s].
  double wanted_speed() const {
    // Without a reading (at the start and after a dropout) the robot stops.
    if (!ahead_.valid()) return 0.0;
    // +infinity means that no obstacle is in range, and -infinity that it is nearer than the range
    // begins. Both give the right result below.
    const double too_far = ahead_.distance() - gap_;
    // Proportional control: with speed = kGain * remaining distance, the remaining distance halves
    // every ln 2 / kGain = 0.35 s without overshoot.
    return std::clamp(kGain * too_far, -speed_, speed_);
  }

  static constexpr double kGain = 2.0;          // [1/s]
  static constexpr double kAcceleration = 1.0;  // [m/s^2]

  cogrsim::MotorHandle left_, right_;
  cogrsim::Infrared ahead_;
  double wheel_radius_ = 0.0;  // [m]
  double speed_ = 0.0;         // [m/s]
  double gap_ = 0.0;           // [m]
  double now_ = 0.0;           // current commanded speed [m/s]
};

}  // namespace

// Parameters with name, unit, default and range, which are checked in the scene: <set gap="20
// cm"/>.
COGRSIM_CONTROLLER(@CLASS@, "@NAME@", version("0.1.0"), author("you"),
                   summary("drives forward and stops at a distance"),
                   parameter("wheel_radius", 0.05, "m", "radius of the wheels").range(0.005, 1.0),
                   parameter("speed", 0.3, "m/s", "maximum speed").range(0.01, 2.0),
                   parameter("gap", 0.2, "m", "distance at which it stops").range(0.06, 0.7))
