// A controller that misbehaves on request, and counts when it does not.
#include <limits>
#include <stdexcept>

#include "cogrsim/control/controller.h"

namespace {

class ProbeController final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    mode_ = robot.parameter<std::string>("mode");
    speed_ = robot.parameter<double>("speed");
    if (mode_ == "missing-devices") {
      robot.motor("lfet");
      robot.sensor<cogrsim::Encoder>("nowhere");
      robot.parameter<int>("speed");
    }
    if (mode_ == "throw-in-configure") throw std::runtime_error("no calibration file");
    if (mode_ == "throw-int-in-configure") throw 42;
    if (!robot.motor_names().empty()) motor_ = robot.motor("left");
  }

  void update(const cogrsim::Tick& tick) override {
    if (mode_ == "throw-in-update" && tick.count == 3) throw std::out_of_range("cell 9 of 8");
    if (mode_ == "nan" && tick.count == 3) motor_.set(std::numeric_limits<double>::quiet_NaN());
    if (mode_ == "count") {
      motor_.set(static_cast<double>(tick.count + 1));
      return;
    }
    motor_.set(speed_);
  }

 private:
  std::string mode_;
  double speed_ = 0.0;
  cogrsim::MotorHandle motor_;
};

}  // namespace

COGRSIM_CONTROLLER(ProbeController, "probe_controller", version("1.0.0"), summary("misbehaves on request"),
                   parameter("mode", "drive", "what to do")
                       .one_of({"drive", "count", "missing-devices", "throw-in-configure",
                                "throw-int-in-configure", "throw-in-update", "nan"}),
                   parameter("speed", 2.0, "rad/s", "wheel speed").range(-10.0, 10.0))
