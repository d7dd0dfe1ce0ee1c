// D. Fox, W. Burgard, S. Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics
// and Automation Magazine 4 (1997), pp. 23-33.

#include "cogrsim/core/constants.h"
#include "plane.h"

namespace algorithms {
namespace {

using cogrsim::kInfinity;
using cogrsim::PlanarPoint;
using cogrsim::PlanarPose;
using cogrsim::PlanarVelocity;
using cogrsim::SteeringCommand;
using cogrsim::SteeringTask;

constexpr double kTwoPi = 6.283185307179586;

/// Distance [m] that a disc of radius `radius` can move along the arc of a velocity until it
/// touches a point in the frame of the vehicle; infinite: never. A disc that already touches it may
/// move away.
double free_arc(const PlanarVelocity& velocity, const PlanarPoint& seen, double radius) {
  // Driving backwards is the reflection of driving forwards.
  const double direction = velocity.forward < 0.0 ? -1.0 : 1.0;
  const double x = direction * seen.x, y = seen.y;
  const double curvature = direction * velocity.turn / std::abs(velocity.forward);
  const bool touching = std::hypot(x, y) < radius;
  if (touching && x > 0.0) return 0.0;
  if (std::abs(curvature) < 1e-9) {
    if (std::abs(y) >= radius || x <= 0.0) return kInfinity;
    return x - std::sqrt(radius * radius - y * y);
  }
  // The centre moves on a circle of radius r about (0, 1/curvature); left and right are symmetric.
  const double r = 1.0 / std::abs(curvature), side = curvature > 0.0 ? y : -y;
  const double d = std::hypot(x, side - r);
  if (!(d > 0.0)) return r > radius ? kInfinity : 0.0;  // the point is the centre of the circle
  const double cosine = (r * r + d * d - radius * radius) / (2.0 * r * d);
  if (cosine >= 1.0) return kInfinity;                         // too far inside or outside
  if (cosine <= -1.0) return 0.0;                              // touches on the whole circle
  double angle = std::atan2(x, r - side) - std::acos(cosine);  // from the start, along the arc
  if (angle < 0.0) angle += kTwoPi;
  return r * angle;
}

/// Pose after driving a velocity for a time.
PlanarPose driven(const PlanarPose& pose, const PlanarVelocity& velocity, double time) {
  const double turned = velocity.turn * time, half = 0.5 * turned;
  const double chord =
      velocity.forward * time * (std::abs(half) < 1e-9 ? 1.0 : std::sin(half) / half);
  return {pose.x + chord * std::cos(pose.heading + half),
          pose.y + chord * std::sin(pose.heading + half), pose.heading + turned};
}

/// Of the velocities that the vehicle can reach within one period it selects the one with the
/// highest
///
///     heading_weight * heading + clearance_weight * clearance + speed_weight * speed
///
/// (each 0 to 1) among those from which it can stop before touching an obstacle.
///
/// A velocity (v, w) is admissible if v T + v^2 / (2 b) is at most the free length of its arc with
/// curvature w/v, where T is the period until the next decision and b = min(a, alpha |v/w|) is the
/// deceleration with which v and w come to rest on the arc. (The paper uses T = 0 and treats v and
/// w separately.) If the vehicle follows its commands and the obstacles are static, continuing on
/// the same arc and braking with b is then admissible again. That velocity is always among the
/// candidates, so there always is an admissible one.
class DynamicWindow final : public cogrsim::Steering {
 public:
  DynamicWindow(const cogrsim::Parameters& parameters, std::uint64_t)
      : lookahead_(std::get<double>(parameters.at("lookahead"))),
        arrival_(std::get<double>(parameters.at("arrival"))),
        margin_(std::get<double>(parameters.at("margin"))),
        heading_weight_(std::get<double>(parameters.at("heading_weight"))),
        clearance_weight_(std::get<double>(parameters.at("clearance_weight"))),
        speed_weight_(std::get<double>(parameters.at("speed_weight"))),
        clearance_range_(std::get<double>(parameters.at("clearance_range"))),
        samples_(static_cast<int>(std::get<std::int64_t>(parameters.at("samples")))) {}

  cogrsim::Result<SteeringCommand> steer(const SteeringTask& task) override {
    if (cogrsim::Result<> checked = cogrsim::check_task(task); !checked) {
      return tl::unexpected(checked.error());
    }
    const PlanarPoint here = position_of(task.pose);
    progress_.update(task.path, here, 2.0 * lookahead_);
    SteeringCommand command;
    command.target = progress_.ahead(here, lookahead_);
    const double to_goal = distance(here, task.path.back());
    if (to_goal <= arrival_ && progress_.length() - progress_.done() <= lookahead_) {
      command.arrived = true;
      command.velocity = braking(task);
      return command;
    }
    seen_.clear();
    for (const PlanarPoint& point : task.obstacles) seen_.push_back(seen_from(task.pose, point));
    choose(task, std::max(to_goal, progress_.length() - progress_.done()), command);
    return command;
  }

  void reset() override { progress_.reset(); }

 private:
  /// The velocity that stops fastest along the current arc.
  static PlanarVelocity braking(const SteeringTask& task) {
    const double v = task.velocity.forward, w = task.velocity.turn;
    if (v == 0.0) return reachable({0.0, 0.0}, task);
    const double slower = std::max(0.0, std::abs(v) - arc_braking(task, v, w) * task.period);
    return {std::copysign(slower, v), w * slower / std::abs(v)};
  }

  static double arc_braking(const SteeringTask& task, double v, double w) {
    if (w == 0.0) return task.limits.acceleration;
    return std::min(task.limits.acceleration, task.limits.turn_acceleration * std::abs(v / w));
  }

  double free_distance_of(const PlanarVelocity& velocity, double radius) const {
    if (velocity.forward == 0.0) return kInfinity;  // a disc turns on the spot
    double least = kInfinity;
    for (const PlanarPoint& point : seen_) {
      least = std::min(least, free_arc(velocity, point, radius));
    }
    return least;
  }

  void choose(const SteeringTask& task, double left, SteeringCommand& command) const {
    const cogrsim::SteeringLimits& limits = task.limits;
    const auto axis = [&](double now, double acceleration, double low, double high) {
      const double from = std::max(low, now - acceleration * task.period);
      const double to = std::min(high, now + acceleration * task.period);
      std::vector<double> values;
      // Faster than allowed, so it can only slow down.
      if (from > to) return std::vector<double>{now > high ? from : to};
      for (int i = 0; i < samples_; ++i) {
        values.push_back(from + (to - from) * i / std::max(1, samples_ - 1));
      }
      if (from < 0.0 && to > 0.0) values.push_back(0.0);
      return values;
    };
    const PlanarVelocity brake = braking(task);
    double best = -kInfinity;
    bool found = false;
    const auto consider = [&](const PlanarVelocity& velocity) {
      const double v = std::abs(velocity.forward);
      const double clear = free_distance_of(velocity, task.radius + margin_);
      const double b = arc_braking(task, velocity.forward, velocity.turn);
      // A tolerance of a nanometre, so that rounding does not exclude a velocity that was just
      // admissible.
      if (v > 0.0 && v * task.period + 0.5 * v * v / b > clear + 1e-9) return;
      // It should be able to stop at the goal, too.
      if (v > 0.0 && v * task.period + 0.5 * v * v / limits.acceleration > left &&
          v > std::abs(brake.forward)) {
        return;
      }
      const double merit = merit_of(task, velocity, clear, command.target);
      if (merit > best) {
        best = merit;
        command.velocity = velocity;
        found = true;
      }
    };
    for (const double v :
         axis(task.velocity.forward, limits.acceleration, -limits.max_reverse, limits.max_speed)) {
      for (const double w :
           axis(task.velocity.turn, limits.turn_acceleration, -limits.max_turn, limits.max_turn)) {
        consider({v, w});
      }
    }
    consider(brake);
    if (!found) {
      command.velocity = brake;
      command.stuck = true;
      command.why = "no admissible velocity: an obstacle is within the stopping distance";
    } else if (command.velocity.forward == 0.0 && task.velocity.forward == 0.0 &&
               std::abs(command.velocity.turn) < 1e-6 && std::abs(task.velocity.turn) < 1e-6) {
      command.stuck = true;
      command.why = "standing still is the best admissible velocity";
    }
  }

  double merit_of(const SteeringTask& task, const PlanarVelocity& velocity, double clear,
                  const PlanarPoint& target) const {
    // The heading after it has stopped turning, following the next period.
    const PlanarPose next = driven(task.pose, velocity, task.period);
    const double coasting =
        0.5 * velocity.turn * std::abs(velocity.turn) / task.limits.turn_acceleration;
    const double wanted = std::atan2(target.y - next.y, target.x - next.x);
    const double off = std::abs(cogrsim::wrapped_angle(wanted - next.heading - coasting));
    return heading_weight_ * (1.0 - 2.0 * off / kTwoPi) +
           clearance_weight_ * std::min(1.0, clear / clearance_range_) +
           speed_weight_ * std::max(0.0, velocity.forward) / task.limits.max_speed;
  }

  double lookahead_, arrival_, margin_;
  double heading_weight_, clearance_weight_, speed_weight_, clearance_range_;
  int samples_;
  Progress progress_;
  std::vector<PlanarPoint> seen_;
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(
    algorithms::DynamicWindow, cogrsim::Steering, "dynamic_window", version("1.0.0"),
    summary("picks the best velocity from which it can still stop before any obstacle"),
    parameter("lookahead", 0.5, "m", "distance of the target along the path").range(1e-3, 1e3),
    parameter("arrival", 0.05, "m", "distance to the end of the path at which it has arrived")
        .range(0.0, 100.0),
    parameter("margin", 0.02, "m", "clearance around the vehicle").range(0.0, 10.0),
    parameter("heading_weight", 2.0, "1", "of the heading towards the target").range(0.0, 1e3),
    parameter("clearance_weight", 0.2, "1", "of the clearance ahead").range(0.0, 1e3),
    parameter("speed_weight", 0.2, "1", "of driving fast").range(0.0, 1e3),
    parameter("clearance_range", 1.0, "m", "a larger clearance counts no more").range(1e-3, 1e3),
    parameter("samples", 15, "number of candidate velocities per axis").range(3, 501))
