// Drives towards an obstacle and stops in front of it.
#include <cogrsim/control/controller.h>

#include <algorithm>
#include <array>

class Parker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    const std::array<const char*, 4> names = {"fl", "fr", "bl", "br"};
    for (std::size_t i = 0; i < names.size(); ++i) wheels_[i] = robot.motor(names[i]);
    eye_ = robot.sensor<cogrsim::Infrared>("eye");
    speed_ = robot.parameter<double>("speed");
    stop_ = robot.parameter<double>("stop");
    smooth_ = robot.parameter<double>("smooth");
  }

  void update(const cogrsim::Tick& tick) override {
    if (!eye_.valid()) return;
    // Nothing in sight is +infinity, too near is -infinity: either would stay in a mean for ever.
    const double now = std::clamp(eye_.distance(), 0.0, 3.0);
    // A mean that forgets: each reading counts less the older it is.
    seen_ = seen_ < 0.0 ? now : seen_ + smooth_ * (now - seen_);
    // In proportion to what is left, up to the speed wanted; and gently at the start.
    const double left = seen_ - stop_;
    const double speed = std::clamp(2.0 * left, -speed_, std::min(speed_, tick.time * 1.0));
    for (cogrsim::MotorHandle& wheel : wheels_) wheel.set(speed / kRadius);
  }

 private:
  static constexpr double kRadius = 0.04;  // of the wheels [m]
  std::array<cogrsim::MotorHandle, 4> wheels_;
  cogrsim::Infrared eye_;
  double speed_ = 0.0, stop_ = 0.0, smooth_ = 1.0;
  double seen_ = -1.0;  // [m], below 0: nothing yet
};

COGRSIM_CONTROLLER(Parker, "parker", version("1.0.0"), author("you"),
                   summary("stops in front of a wall"),
                   parameter("speed", 0.4, "m/s", "at most").range(0.0, 2.0),
                   parameter("stop", 0.2, "m", "to the wall").range(0.0, 5.0),
                   parameter("smooth", 1.0, "1", "weight of a new reading").range(0.01, 1.0))
