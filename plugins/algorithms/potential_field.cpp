// O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", The International
// Journal of Robotics Research 5 (1986), pp. 90-98.
#include <fmt/format.h>

#include "plane.h"

namespace algorithms {
namespace {

using cogrsim::PlanarPoint;
using cogrsim::SteeringCommand;
using cogrsim::SteeringTask;

/// The goal attracts and obstacles within `reach` repel; the vehicle drives in the direction of the
/// sum.
///
///     attraction:  k_a (goal - p)                                  [m/s]
///     repulsion:   k_r (1/d - 1/d_0) 1/d^2 (p - obstacle) / |p - obstacle|   for d < d_0
///
/// with d the distance of the obstacle from the vehicle's disc. The sum is the desired velocity,
/// which the paper reaches through a force and damping; as there it is limited to the maximum
/// speed. Of the path only the last point, the goal, is used.
///
/// The field may have local minima in front of a wall or in a concave obstacle. The sum vanishes
/// there, which is reported as stuck; this method cannot leave a local minimum.
class PotentialField final : public cogrsim::Steering {
 public:
  PotentialField(const cogrsim::Parameters& parameters, std::uint64_t)
      : attraction_(std::get<double>(parameters.at("attraction"))),
        repulsion_(std::get<double>(parameters.at("repulsion"))),
        reach_(std::get<double>(parameters.at("reach"))),
        arrival_(std::get<double>(parameters.at("arrival"))),
        still_(std::get<double>(parameters.at("still"))),
        turn_gain_(std::get<double>(parameters.at("turn_gain"))),
        nearest_only_(std::get<std::string>(parameters.at("points")) == "nearest") {}

  cogrsim::Result<SteeringCommand> steer(const SteeringTask& task) override {
    if (cogrsim::Result<> checked = cogrsim::check_task(task); !checked) {
      return tl::unexpected(checked.error());
    }
    SteeringCommand command;
    command.target = task.path.back();
    const PlanarPoint here = position_of(task.pose);
    const double to_goal = distance(here, command.target);
    if (to_goal <= arrival_) {
      command.arrived = true;
      command.velocity = reachable({0.0, 0.0}, task);
      return command;
    }
    const PlanarPoint sum = field(task, here);
    const double strength = std::hypot(sum.x, sum.y);
    if (strength < still_) {
      command.stuck = true;
      command.why = fmt::format("a local minimum of the field, {:.3g} m from the goal", to_goal);
      command.velocity = reachable({0.0, 0.0}, task);
      return command;
    }
    const double off = cogrsim::wrapped_angle(std::atan2(sum.y, sum.x) - task.pose.heading);
    const double speed = std::min({strength, task.limits.max_speed,
                                   stopping_speed(to_goal, task.limits.acceleration, task.period)});
    command.velocity = reachable({speed * std::max(0.0, std::cos(off)), turn_gain_ * off}, task);
    return command;
  }

 private:
  PlanarPoint field(const SteeringTask& task, const PlanarPoint& here) const {
    const PlanarPoint& goal = task.path.back();
    PlanarPoint sum{attraction_ * (goal.x - here.x), attraction_ * (goal.y - here.y)};
    const auto repel = [&](const PlanarPoint& obstacle) {
      const double separation = distance(here, obstacle);
      // Never exactly at the edge of the disc, where the field is infinite; inside, it repels as
      // strongly.
      const double gap = std::max(separation - task.radius, 1e-3 * reach_);
      if (gap >= reach_ || !(separation > 0.0)) return;
      const double repulsion = repulsion_ * (1.0 / gap - 1.0 / reach_) / (gap * gap);
      sum.x += repulsion * (here.x - obstacle.x) / separation;
      sum.y += repulsion * (here.y - obstacle.y) / separation;
    };
    if (!nearest_only_) {
      for (const PlanarPoint& obstacle : task.obstacles) repel(obstacle);
    } else if (!task.obstacles.empty()) {
      repel(*std::min_element(task.obstacles.begin(), task.obstacles.end(),
                              [&](const PlanarPoint& a, const PlanarPoint& b) {
                                return distance(here, a) < distance(here, b);
                              }));
    }
    return sum;
  }

  double attraction_, repulsion_, reach_, arrival_, still_, turn_gain_;
  bool nearest_only_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(
    algorithms::PotentialField, cogrsim::Steering, "potential_field", version("1.0.0"),
    summary("follows a potential field with an attracting goal and repelling obstacles"),
    parameter("attraction", 1.0, "1/s", "k_a: speed per distance from the goal").range(1e-6, 1e6),
    parameter("repulsion", 1e-3, "m^4/s", "k_r").range(0.0, 1e6),
    parameter("reach", 0.4, "m", "d_0: farther obstacles have no effect").range(1e-3, 1e3),
    parameter("points", "sum", "whether all points repel, or, for dense scans, the nearest alone")
        .one_of({"sum", "nearest"}),
    parameter("arrival", 0.05, "m", "distance to the goal at which it has arrived")
        .range(0.0, 100.0),
    parameter("still", 0.01, "m/s", "a weaker field away from the goal is a local minimum")
        .range(1e-9, 10.0),
    parameter("turn_gain", 4.0, "1/s", "turn rate per angle to the field").range(1e-3, 1e3))
