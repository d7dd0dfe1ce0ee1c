// A controller that drives its only motor with what it is asked for.
#include "cogrsim/control/controller.h"

namespace {

class Asker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    motor_ = robot.motor("drive");
    speed_ = robot.input("speed", 1.0, -2.0, 4.0, "rad/s");
    trim_ = robot.input("trim", 0.0, -0.5, 0.5);
  }
  void update(const cogrsim::Tick&) override { motor_.set(speed_.value() + trim_.value()); }

 private:
  cogrsim::MotorHandle motor_;
  cogrsim::InputHandle speed_, trim_;
};

}  // namespace

COGRSIM_CONTROLLER(Asker, "studio_test_asker", version("1.0.0"))
