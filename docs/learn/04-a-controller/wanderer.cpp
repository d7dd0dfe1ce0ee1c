// Drives forward until an obstacle is near, then turns until the path is free.
#include <cogrsim/control/controller.h>

#include <algorithm>

class Wanderer final : public cogrsim::Controller {
 public:
  // Once, before the run: ask for all you need.
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("base.left");
    right_ = robot.motor("base.right");
    scan_ = robot.sensor<cogrsim::Lidar>("base.scan");
    speed_ = robot.parameter<double>("speed");
    near_ = robot.parameter<double>("near");
  }

  // Many times a second: look, decide, act.
  void update(const cogrsim::Tick&) override {
    if (!scan_.valid()) return;
    const std::vector<double> ranges = scan_.ranges();  // [m], +infinity: nothing in sight
    const double distance = *std::min_element(ranges.begin(), ranges.end());
    if (distance < near_) turning_ = true;
    if (distance > 1.5 * near_) turning_ = false;
    const double rim = speed_ / kRadius;  // [rad/s]
    left_.set(turning_ ? -rim / 2 : rim);
    right_.set(turning_ ? rim / 2 : rim);
  }

 private:
  static constexpr double kRadius = 0.05;  // of the wheels [m]
  cogrsim::MotorHandle left_, right_;
  cogrsim::Lidar scan_;
  double speed_ = 0.0, near_ = 0.0;
  bool turning_ = false;
};

COGRSIM_CONTROLLER(
    Wanderer, "wanderer", version("1.0.0"), author("you"), summary("drives about and avoids walls"),
    parameter("speed", 0.3, "m/s", "of driving forward").range(0.0, 2.0),
    parameter("near", 0.25, "m", "a wall nearer than this makes it turn").range(0.05, 5.0))
