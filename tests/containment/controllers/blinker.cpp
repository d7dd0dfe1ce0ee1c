// A controller that switches its encoder off and on again, in one call, and in the next one once more.
#include "cogrsim/control/controller.h"

namespace {

class Blinker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    encoder_ = robot.any_sensor("encoder");
    motor_ = robot.motor("left");
    at_ = static_cast<std::uint64_t>(robot.parameter<int>("at"));
  }
  void update(const cogrsim::Tick& tick) override {
    motor_.set(2.0);
    if (tick.count != at_ && tick.count != at_ + 1) return;
    encoder_.enable(false);
    encoder_.enable(true);
  }

 private:
  cogrsim::SensorHandle encoder_;
  cogrsim::MotorHandle motor_;
  std::uint64_t at_ = 0;
};

}  // namespace

COGRSIM_CONTROLLER(Blinker, "blinker", parameter("at", 1, "number of the update"))
