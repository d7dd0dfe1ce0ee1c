// A controller with an input, whose value it publishes; or with one that is wrong.
#include <limits>
#include <stdexcept>

#include "cogrsim/control/controller.h"

namespace {

class Asker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = std::make_unique<cogrsim::Assembly>(robot);
    speed_ = robot.input("speed", robot.parameter<double>("start"), -2.0, 3.0, "rad/s");
    const auto wrong = wrong_ = robot.parameter<std::string>("wrong");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (wrong == "twice") robot.input("speed", 0.0, -1.0, 1.0);
    if (wrong == "limits") robot.input("a", 0.0, 1.0, -1.0);
    if (wrong == "nan") robot.input("a", 0.0, nan, 1.0);
    if (wrong == "value") robot.input("a", 2.0, -1.0, 1.0);
    if (wrong == "name") robot.input("", 0.0, -1.0, 1.0);
    if (wrong == "bytes") robot.input("a\xff", 0.0, -1.0, 1.0);
    if (wrong == "control") robot.input("a\nb", 0.0, -1.0, 1.0);
    if (wrong == "unit") robot.input("a", 0.0, -1.0, 1.0, "m\x1b[2J");
    if (wrong == "many")
      for (int i = 0; i < 64; ++i) robot.input("i" + std::to_string(i), 0.0, -1.0, 1.0);
  }
  void update(const cogrsim::Tick& tick) override {
    robot_->publish("asked", speed_.value());
    if (wrong_ == "late" && tick.count == 2) robot_->input("late", 0.0, -1.0, 1.0);
    if (wrong_ == "throw" && tick.count == 2) throw std::runtime_error("enough");
  }
  std::optional<std::string> save() const override { return ""; }

 private:
  std::unique_ptr<cogrsim::Assembly> robot_;
  cogrsim::InputHandle speed_;
  std::string wrong_;
};

}  // namespace

COGRSIM_CONTROLLER(Asker, "asker", parameter("start", 1.0, "", "value of the input at the start"),
                   parameter("wrong", "", "what is declared wrongly"),
                   output("asked", "rad/s", "the input"))
