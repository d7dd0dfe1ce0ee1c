#include "path_follower.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/core/constants.h"

namespace diff_drive {

namespace {

using cogrsim::kPi;
constexpr double kTurnOnTheSpot = kPi / 4;  // heading error from which it turns on the spot [rad]
}  // namespace

WheelSpeeds wheel_speeds(const Velocity& velocity, double radius, double track) {
  const double difference = velocity.turn * track / 2;
  return {(velocity.forward - difference) / radius, (velocity.forward + difference) / radius};
}

WheelSpeeds limited(const WheelSpeeds& speeds, double max_left, double max_right) {
  double factor = 1.0;
  if (std::abs(speeds.left) > max_left) factor = std::min(factor, max_left / std::abs(speeds.left));
  if (std::abs(speeds.right) > max_right)
    factor = std::min(factor, max_right / std::abs(speeds.right));
  return {speeds.left * factor, speeds.right * factor};
}

PlanarPose rolled(const PlanarPose& pose, double left, double right, double track) {
  const double turn = (right - left) / track;
  const double arc = (left + right) / 2;
  // The chord of an arc is shorter than the arc by the factor sin(h)/h, with h half the arc's
  // angle.
  const double half = turn / 2;
  const double shortening = std::abs(half) < 1e-6 ? 1 - half * half / 6 : std::sin(half) / half;
  const double direction = pose.heading + half;
  return {pose.x + arc * shortening * std::cos(direction),
          pose.y + arc * shortening * std::sin(direction), pose.heading + turn};
}

PathFollower::PathFollower(std::vector<Point> waypoints, const FollowerSettings& settings)
    : waypoints_(std::move(waypoints)), settings_(settings), done_(waypoints_.empty()) {}

void PathFollower::advance() {
  from_ = waypoints_[next_];
  ++next_;
  if (next_ < waypoints_.size()) return;
  if (settings_.loop) {
    next_ = 0;
  } else {
    done_ = true;
  }
}

Velocity PathFollower::update(const PlanarPose& pose) {
  if (!started_ && !done_) {
    from_ = {pose.x, pose.y};
    started_ = true;
  }
  // Several waypoints may be within the tolerance; at most one round, or a loop would never end.
  for (std::size_t tried = 0; !done_ && tried < waypoints_.size(); ++tried) {
    const Point& to = waypoints_[next_];
    const double distance = std::hypot(to.x - pose.x, to.y - pose.y);
    const double length = std::hypot(to.x - from_.x, to.y - from_.y);
    // A position beyond the end of the line counts as arrived, so that a small miss causes no
    // circling.
    const double along =
        length > 0
            ? ((pose.x - from_.x) * (to.x - from_.x) + (pose.y - from_.y) * (to.y - from_.y)) /
                  length
            : 0.0;
    const bool passed = length > 0 && along >= length && distance < 3 * settings_.arrival;
    if (distance > settings_.arrival && !passed) break;
    advance();
  }
  if (done_) return {};

  const Point& to = waypoints_[next_];
  const double dx = to.x - from_.x, dy = to.y - from_.y;
  const double length = std::hypot(dx, dy);
  Point aim = to;
  if (length > 0) {
    const double along = ((pose.x - from_.x) * dx + (pose.y - from_.y) * dy) / length;
    const double s = std::clamp(along + settings_.lookahead, 0.0, length);
    aim = {from_.x + dx / length * s, from_.y + dy / length * s};
  }
  const double error =
      cogrsim::wrapped_angle(std::atan2(aim.y - pose.y, aim.x - pose.x) - pose.heading);
  double speed = settings_.speed * std::max(0.0, 1.0 - std::abs(error) / kTurnOnTheSpot);
  if (!settings_.loop && next_ + 1 == waypoints_.size()) {
    const double left = std::hypot(to.x - pose.x, to.y - pose.y);
    speed = std::min(speed, std::sqrt(2 * settings_.acceleration * left));
  }
  const double turn =
      std::clamp(settings_.turn_gain * error, -settings_.max_turn, settings_.max_turn);
  return {speed, turn};
}

}  // namespace diff_drive
