// Exercises 1 and 2: a wanderer that turns to a given side, or tosses a coin, and publishes how often it turned.
#include <cogrsim/control/controller.h>

#include <algorithm>
#include <optional>

class Tosser final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = robot;  // needed in update(), for the coin and the output
    left_ = robot.motor("base.left");
    right_ = robot.motor("base.right");
    scan_ = robot.sensor<cogrsim::Lidar>("base.scan");
    speed_ = robot.parameter<double>("speed");
    near_ = robot.parameter<double>("near");
    side_ = robot.parameter<std::string>("side");
    robot.publish("turns", 0);
  }

  void update(const cogrsim::Tick&) override {
    if (!scan_.valid()) return;
    const std::vector<double> ranges = scan_.ranges();
    const double distance = *std::min_element(ranges.begin(), ranges.end());
    if (distance < near_ && turn_ == 0.0) {
      turn_ = side_ == "left" ? 1.0 : -1.0;
      // The robot's own stream, from the run's seed: the same run again tosses the same.
      if (side_ == "any") turn_ = robot_->uniform(0.0, 1.0) < 0.5 ? 1.0 : -1.0;
      robot_->publish("turns", ++turns_);
    }
    if (distance > 1.5 * near_) turn_ = 0.0;
    const double rim = speed_ / kRadius;
    left_.set(turn_ == 0.0 ? rim : -turn_ * rim / 2);
    right_.set(turn_ == 0.0 ? rim : turn_ * rim / 2);
  }

 private:
  static constexpr double kRadius = 0.05;  // [m]
  std::optional<cogrsim::Assembly> robot_;
  cogrsim::MotorHandle left_, right_;
  cogrsim::Lidar scan_;
  double speed_ = 0.0, near_ = 0.0;
  std::string side_;
  double turn_ = 0.0;  // 1 to the left, -1 to the right, 0 straight
  int turns_ = 0;
};

COGRSIM_CONTROLLER(
    Tosser, "tosser", version("1.0.0"), summary("wanders and turns to a given side"),
    parameter("speed", 0.3, "m/s", "of driving forward").range(0.0, 2.0),
    parameter("near", 0.25, "m", "a wall nearer than this makes it turn").range(0.05, 5.0),
    parameter("side", "any", "to which it turns").one_of({"left", "right", "any"}),
    output("turns", "1", "how often it began to turn"))
