// R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", report
// CMU-RI-TR-92-01, Carnegie Mellon University (1992).
#include "plane.h"

namespace algorithms {
namespace {

using cogrsim::PlanarPoint;
using cogrsim::PlanarVelocity;
using cogrsim::SteeringCommand;
using cogrsim::SteeringTask;

/// Drives the arc that is tangent to the heading and meets the path at the look-ahead distance: the
/// curvature is 2 y / D^2 for a target at the distance D with the lateral offset y to the left.
///
/// Extensions of the paper: D is the actual distance to the target, which differs from the
/// look-ahead distance at the end of the path or far from it; the vehicle turns on the spot towards
/// a target behind it; it brakes at the end of the path; a limited turn rate reduces the speed and
/// not the curvature.
class PurePursuit final : public cogrsim::Steering {
 public:
  PurePursuit(const cogrsim::Parameters& parameters, std::uint64_t)
      : lookahead_(std::get<double>(parameters.at("lookahead"))),
        arrival_(std::get<double>(parameters.at("arrival"))),
        on_the_spot_(std::get<bool>(parameters.at("turn_on_the_spot"))) {}

  cogrsim::Result<SteeringCommand> steer(const SteeringTask& task) override {
    if (cogrsim::Result<> checked = cogrsim::check_task(task); !checked) {
      return tl::unexpected(checked.error());
    }
    const PlanarPoint here = position_of(task.pose);
    progress_.update(task.path, here, 2.0 * lookahead_);
    SteeringCommand command;
    command.target = progress_.ahead(here, lookahead_);
    const double left = progress_.length() - progress_.done();
    const double to_goal = distance(here, task.path.back());
    if (to_goal <= arrival_ && left <= lookahead_) {
      command.arrived = true;
      command.velocity = reachable({0.0, 0.0}, task);
      return command;
    }
    command.velocity = reachable(wanted(task, command.target, std::max(to_goal, left)), task);
    return command;
  }

  void reset() override { progress_.reset(); }

 private:
  PlanarVelocity wanted(const SteeringTask& task, const PlanarPoint& target, double left) const {
    const PlanarPoint seen = seen_from(task.pose, target);
    if (seen.x <= 0.0 && on_the_spot_) {
      // As fast as it can turn and still stop at the heading of the target.
      const double off = std::abs(std::atan2(seen.y, seen.x));
      const double rate = std::min(task.limits.max_turn,
                                   stopping_speed(off, task.limits.turn_acceleration, task.period));
      return {0.0, seen.y >= 0.0 ? rate : -rate};
    }
    const double squared = seen.x * seen.x + seen.y * seen.y;
    const double curvature = squared > 0.0 ? 2.0 * seen.y / squared : 0.0;
    double speed = std::min(task.limits.max_speed,
                            stopping_speed(left, task.limits.acceleration, task.period));
    if (std::abs(curvature) * speed > task.limits.max_turn) {
      speed = task.limits.max_turn / std::abs(curvature);
    }
    // The curvature must hold for the actual speed.
    const double real = reachable({speed, 0.0}, task).forward;
    return {speed, curvature * real};
  }

  double lookahead_, arrival_;
  bool on_the_spot_;
  Progress progress_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::PurePursuit, cogrsim::Steering, "pure_pursuit", version("1.0.0"),
                  summary("follows a path along arcs to a point ahead on it; ignores obstacles"),
                  parameter("lookahead", 0.3, "m",
                            "distance of the target point; a short one is exact but "
                            "oscillates, a long one is smooth but cuts corners")
                      .range(1e-3, 100.0),
                  parameter("arrival", 0.05, "m",
                            "distance to the end of the path at which it has arrived")
                      .range(0.0, 100.0),
                  parameter("turn_on_the_spot", true,
                            "turns without driving while the point is behind it"))
