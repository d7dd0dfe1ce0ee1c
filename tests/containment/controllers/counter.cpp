// A controller that counts, in several versions: 1 by one; 2 by ten; 3 without a memory; 4 with a
// parameter that must be set; 5 publishes something else; 6 takes no memory; 7 does not configure.
#include <stdexcept>

#include "cogrsim/control/controller.h"

namespace {

int total = 0;  // of this library: another version must have its own

class Counter final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = std::make_unique<cogrsim::Assembly>(robot);
    motor_ = robot.motor("left");
    motor_.set(0.5);
    robot.input("speed", COUNTER_VERSION, 0.0, 10.0);
    if (COUNTER_VERSION == 7) throw std::runtime_error("half finished");
  }
  void update(const cogrsim::Tick&) override {
    count_ += COUNTER_VERSION == 2 ? 10 : 1;
    ++total;
    motor_.set(0.01 * count_ + robot_->uniform(0.0, 0.001));
    robot_->publish(COUNTER_VERSION == 5 ? "sum" : "count", count_);
    if (COUNTER_VERSION != 5) robot_->publish("total", total);
  }
  std::optional<std::string> save() const override {
    if (COUNTER_VERSION == 3) return std::nullopt;
    return std::to_string(count_);
  }
  void restore(const std::string& memory) override {
    if (COUNTER_VERSION == 6) throw std::runtime_error("another format");
    count_ = std::stoi(memory);
  }

 private:
  std::unique_ptr<cogrsim::Assembly> robot_;
  cogrsim::MotorHandle motor_;
  int count_ = 0;
};

}  // namespace

#if COUNTER_VERSION == 4
COGRSIM_CONTROLLER(Counter, "counter", version("4.0.0"),
                   parameter("must", 1.0, "m", "must be set").must_be_set(),
                   output("count", "1", "so far"), output("total", "1", "of this library"))
#elif COUNTER_VERSION == 5
COGRSIM_CONTROLLER(Counter, "counter", version("5.0.0"), output("sum", "1", "so far"))
#else
COGRSIM_CONTROLLER(Counter, "counter", version(std::to_string(COUNTER_VERSION) + ".0.0"),
                   output("count", "1", "so far"), output("total", "1", "of this library"))
#endif
