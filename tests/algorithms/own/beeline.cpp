// Drives straight to the goal and stops in front of obstacles.
#include <algorithm>
#include <cmath>

#include "cogrsim/algorithms/steering.h"

class Beeline final : public cogrsim::Steering {
 public:
  Beeline(const cogrsim::Parameters& parameters, std::uint64_t /*seed*/)
      : clearance_(std::get<double>(parameters.at("clearance"))) {}

  cogrsim::Result<cogrsim::SteeringCommand> steer(const cogrsim::SteeringTask& task) override {
    if (auto checked = cogrsim::check_task(task); !checked) return tl::unexpected(checked.error());
    cogrsim::SteeringCommand command;
    command.target = task.path.back();
    const double dx = command.target.x - task.pose.x, dy = command.target.y - task.pose.y;
    const double left = std::hypot(dx, dy);
    command.arrived = left < clearance_;
    if (command.arrived) return command;
    for (const cogrsim::PlanarPoint& point : task.obstacles) {
      if (std::hypot(point.x - task.pose.x, point.y - task.pose.y) < task.radius + clearance_) {
        command.stuck = true;
        command.why = "an obstacle blocks the path";
        return command;
      }
    }
    const double off = cogrsim::wrapped_angle(std::atan2(dy, dx) - task.pose.heading);
    command.velocity.turn = std::clamp(2.0 * off, -task.limits.max_turn, task.limits.max_turn);
    command.velocity.forward = std::min(task.limits.max_speed, left) * std::max(0.0, std::cos(off));
    return command;
  }

 private:
  double clearance_;  // [m]
};

COGRSIM_ALGORITHM(Beeline, cogrsim::Steering, "beeline", version("1.0.0"), author("you"),
                  summary("drives straight to the goal"),
                  parameter("clearance", 0.1, "m", "kept from obstacles").range(0.0, 10.0))
