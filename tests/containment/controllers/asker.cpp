// A controller with an input, whose value it publishes; or with one that is wrong.
#include <limits>

#include "cogrsim/control/controller.h"

namespace {

class Asker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = std::make_unique<cogrsim::Assembly>(robot);
    speed_ = robot.input("speed", 1.0, -2.0, 3.0, "rad/s");
    const auto wrong = robot.parameter<std::string>("wrong");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (wrong == "twice") robot.input("speed", 0.0, -1.0, 1.0);
    if (wrong == "limits") robot.input("a", 0.0, 1.0, -1.0);
    if (wrong == "nan") robot.input("a", 0.0, nan, 1.0);
    if (wrong == "value") robot.input("a", 2.0, -1.0, 1.0);
    if (wrong == "name") robot.input("", 0.0, -1.0, 1.0);
    if (wrong == "many")
      for (int i = 0; i < 64; ++i) robot.input("i" + std::to_string(i), 0.0, -1.0, 1.0);
  }
  void update(const cogrsim::Tick&) override { robot_->publish("asked", speed_.value()); }
  std::optional<std::string> save() const override { return ""; }

 private:
  std::unique_ptr<cogrsim::Assembly> robot_;
  cogrsim::InputHandle speed_;
};

}  // namespace

COGRSIM_CONTROLLER(Asker, "asker", parameter("wrong", "", "what is declared wrongly"),
                   output("asked", "rad/s", "the input"))
