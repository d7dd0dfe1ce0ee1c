// Common functions of the steering methods.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "cogrsim/algorithms/steering.h"

namespace algorithms {

inline double distance(const cogrsim::PlanarPoint& a, const cogrsim::PlanarPoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

inline cogrsim::PlanarPoint position_of(const cogrsim::PlanarPose& pose) {
  return {pose.x, pose.y};
}

/// A point in the frame of the vehicle: x forward, y to the left [m].
inline cogrsim::PlanarPoint seen_from(const cogrsim::PlanarPose& pose,
                                      const cogrsim::PlanarPoint& point) {
  const double dx = point.x - pose.x, dy = point.y - pose.y;
  const double c = std::cos(pose.heading), s = std::sin(pose.heading);
  return {c * dx + s * dy, -s * dx + c * dy};
}

/// Highest speed from which the vehicle, after driving for one more period, still stops within
/// `distance` with the deceleration `a`: v T + v^2 / (2 a) = distance.
inline double stopping_speed(double distance, double a, double period) {
  if (!(distance > 0.0)) return 0.0;
  if (!std::isfinite(a) || !std::isfinite(distance)) return distance / period;
  return std::sqrt(a * a * period * period + 2.0 * a * distance) - a * period;
}

/// The velocity closest to `wanted` that the vehicle can reach within one period.
inline cogrsim::PlanarVelocity reachable(const cogrsim::PlanarVelocity& wanted,
                                         const cogrsim::SteeringTask& task) {
  const cogrsim::SteeringLimits& limits = task.limits;
  const auto towards = [](double from, double to, double most) {
    return std::clamp(to, from - most, from + most);
  };
  return {towards(task.velocity.forward,
                  std::clamp(wanted.forward, -limits.max_reverse, limits.max_speed),
                  limits.acceleration * task.period),
          towards(task.velocity.turn, std::clamp(wanted.turn, -limits.max_turn, limits.max_turn),
                  limits.turn_acceleration * task.period)};
}

/// A path and the progress of the vehicle along it.
class Progress {
 public:
  void reset() { path_.clear(); }

  /// Moves the progress to the nearest point of the path, at most `window` beyond the previous one,
  /// so that no loop of the path is skipped. A new path starts at its nearest point.
  void update(const std::vector<cogrsim::PlanarPoint>& path, const cogrsim::PlanarPoint& here,
              double window) {
    const auto same = [](const cogrsim::PlanarPoint& a, const cogrsim::PlanarPoint& b) {
      return a.x == b.x && a.y == b.y;
    };
    const bool known =
        path.size() == path_.size() && std::equal(path.begin(), path.end(), path_.begin(), same);
    if (!known) {
      path_ = path;
      along_.assign(path.size(), 0.0);
      for (std::size_t i = 1; i < path.size(); ++i) {
        along_[i] = along_[i - 1] + distance(path[i - 1], path[i]);
      }
      done_ = 0.0;
    }
    const double last = known ? done_ + window : along_.back();
    double nearest = std::numeric_limits<double>::infinity(), found = done_;
    for (std::size_t i = piece_at(done_); i < path_.size() && along_[i - 1] <= last; ++i) {
      const double length = along_[i] - along_[i - 1];
      if (!(length > 0.0)) continue;
      const cogrsim::PlanarPoint &a = path_[i - 1], &b = path_[i];
      double at = ((here.x - a.x) * (b.x - a.x) + (here.y - a.y) * (b.y - a.y)) / length;
      at = std::clamp(at, std::max(0.0, done_ - along_[i - 1]),
                      std::min(length, last - along_[i - 1]));
      const double share = at / length;
      const double off = distance(here, {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)});
      if (off < nearest) {
        nearest = off;
        found = along_[i - 1] + at;
      }
    }
    done_ = found;
  }

  double done() const { return done_; }  ///< [m]
  double length() const { return along_.back(); }

  /// Point at this distance along the path [m], at most its end.
  cogrsim::PlanarPoint point_at(double along) const {
    const std::size_t i = piece_at(along);
    if (i >= path_.size()) return path_.back();
    const double length = along_[i] - along_[i - 1];
    const double share = length > 0.0 ? std::max(0.0, along - along_[i - 1]) / length : 0.0;
    return {path_[i - 1].x + share * (path_[i].x - path_[i - 1].x),
            path_[i - 1].y + share * (path_[i].y - path_[i - 1].y)};
  }

  /// The first point of the path after the progress at the distance `radius` from `here`; the end
  /// if all remaining points are nearer; the progress itself if it is already farther away.
  cogrsim::PlanarPoint ahead(const cogrsim::PlanarPoint& here, double radius) const {
    cogrsim::PlanarPoint from = point_at(done_);
    if (distance(from, here) >= radius) return from;
    for (std::size_t i = piece_at(done_); i < path_.size(); ++i) {
      if (along_[i] <= done_) continue;
      const cogrsim::PlanarPoint to = path_[i];
      if (distance(to, here) >= radius) {
        // |from + t (to - from) - here| = radius; from is inside, so the larger root is needed.
        const double dx = to.x - from.x, dy = to.y - from.y;
        const double ox = from.x - here.x, oy = from.y - here.y;
        const double a = dx * dx + dy * dy, b = ox * dx + oy * dy;
        const double c = ox * ox + oy * oy - radius * radius;
        const double t = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
        return {from.x + t * dx, from.y + t * dy};
      }
      from = to;
    }
    return path_.back();
  }

 private:
  /// Index i of the first segment, from point i - 1 to i, that does not end before `along`.
  std::size_t piece_at(double along) const {
    const auto end = std::lower_bound(along_.begin(), along_.end(), along);
    return std::max<std::size_t>(1, static_cast<std::size_t>(end - along_.begin()));
  }

  std::vector<cogrsim::PlanarPoint> path_;
  std::vector<double> along_;  // path length up to each point [m]
  double done_ = 0.0;          // [m]
};

}  // namespace algorithms
