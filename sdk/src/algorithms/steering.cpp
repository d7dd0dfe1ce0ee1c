#include "cogrsim/algorithms/steering.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"

namespace cogrsim {

namespace {

bool finite(const PlanarPoint& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

Result<> check_points(const char* what, const std::vector<PlanarPoint>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!finite(points[i])) {
      return fail(fmt::format("{} point {} is ({}, {}), which is not finite", what, i, points[i].x,
                              points[i].y));
    }
  }
  return {};
}

struct Bound {
  const char* name;
  double value;
  bool zero_allowed;
};

}  // namespace

Result<> check_task(const SteeringTask& task) {
  if (!(finite({task.pose.x, task.pose.y}) && std::isfinite(task.pose.heading))) {
    return fail(fmt::format("the pose is ({}, {}, {}), which is not finite", task.pose.x,
                            task.pose.y, task.pose.heading));
  }
  if (!(std::isfinite(task.velocity.forward) && std::isfinite(task.velocity.turn))) {
    return fail(fmt::format("the present velocity is ({}, {}), which is none",
                            task.velocity.forward, task.velocity.turn));
  }
  if (task.path.empty()) return fail("the path is empty: it needs a goal at least");
  if (Result<> checked = check_points("path", task.path); !checked) return checked;
  if (Result<> checked = check_points("obstacle", task.obstacles); !checked) return checked;
  const SteeringLimits& limits = task.limits;
  for (const Bound& bound :
       {Bound{"max_speed", limits.max_speed, false}, Bound{"max_reverse", limits.max_reverse, true},
        Bound{"max_turn", limits.max_turn, false},
        Bound{"acceleration", limits.acceleration, false},
        Bound{"turn_acceleration", limits.turn_acceleration, false},
        Bound{"radius", task.radius, true}, Bound{"period", task.period, false}}) {
    if (bound.value > 0.0 || (bound.zero_allowed && bound.value == 0.0)) continue;
    return fail(fmt::format("{} is {}, but must be {}", bound.name, bound.value,
                            bound.zero_allowed ? "at least 0" : "above 0"));
  }
  for (const Bound& bound :
       {Bound{"max_speed", limits.max_speed, false}, Bound{"max_reverse", limits.max_reverse, true},
        Bound{"max_turn", limits.max_turn, false}, Bound{"radius", task.radius, true},
        Bound{"period", task.period, false}}) {
    if (!std::isfinite(bound.value)) return fail(fmt::format("{} must be finite", bound.name));
  }
  return {};
}

std::vector<PlanarPoint> ray_ends(const PlanarPose& sensor, const std::vector<double>& bearings,
                                  const std::vector<double>& ranges) {
  std::vector<PlanarPoint> points;
  const std::size_t count = std::min(bearings.size(), ranges.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(ranges[i]) || ranges[i] < 0.0) continue;
    const double angle = sensor.heading + bearings[i];
    const PlanarPoint end{sensor.x + ranges[i] * std::cos(angle),
                          sensor.y + ranges[i] * std::sin(angle)};
    if (finite(end)) points.push_back(end);
  }
  return points;
}

PlanarPose planar(const Pose& X_WB) {
  const Vec3 ahead = X_WB.q * Vec3::UnitX();
  return {X_WB.p.x(), X_WB.p.y(), std::atan2(ahead.y(), ahead.x())};
}

double wrapped_angle(double angle) {
  const double turned = std::remainder(angle, 2.0 * kPi);  // [-pi, pi]
  return turned <= -kPi ? kPi : turned;
}

}  // namespace cogrsim
