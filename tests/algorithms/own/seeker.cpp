// Drives a two-wheel robot to a goal with whatever steering the scene names.
#include <memory>
#include <stdexcept>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/control/controller.h"

class Seeker final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    left_ = robot.motor("left");
    right_ = robot.motor("right");
    pose_ = robot.sensor<cogrsim::PoseSensor>("pose");
    steering_ = robot.algorithm<cogrsim::Steering>(robot.parameter<std::string>("steering"));
    task_.path = {{robot.parameter<double>("x"), robot.parameter<double>("y")}};
  }

  void update(const cogrsim::Tick& tick) override {
    if (!pose_.valid()) return;
    task_.pose = cogrsim::planar(pose_.pose());
    task_.period = tick.period;
    const auto command = steering_->steer(task_);
    if (!command) throw std::runtime_error(command.error().text());
    task_.velocity = command->velocity;
    const double turn = 0.5 * kTrack * command->velocity.turn;
    left_.set((command->velocity.forward - turn) / kRadius);
    right_.set((command->velocity.forward + turn) / kRadius);
  }

 private:
  static constexpr double kRadius = 0.04, kTrack = 0.2;  // of the wheels [m]
  cogrsim::MotorHandle left_, right_;
  cogrsim::PoseSensor pose_;
  std::shared_ptr<cogrsim::Steering> steering_;
  cogrsim::SteeringTask task_;
};

COGRSIM_CONTROLLER(Seeker, "seeker", version("1.0.0"), summary("drives to a goal"),
                   parameter("steering", "pure_pursuit", "name of a steering algorithm"),
                   parameter("x", 0.0, "m", "of the goal"), parameter("y", 0.0, "m", "of the goal"))
