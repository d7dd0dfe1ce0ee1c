#include "traffic.h"

#include <algorithm>
#include <cmath>

namespace box_carrier {

namespace {
constexpr double kSmoothing = 0.25;  ///< [s]
constexpr double kForesight = 0.4;   ///< [s]: two readings and braking from cruising speed
constexpr double kMoves = 0.06;      ///< a slower robot counts as standing [m/s]
}  // namespace

void Neighbour::see(const PlanarPoint& tower, double time) {
  const double passed = time - time_;
  if (position_ && passed > 0.0 && passed < 1.0) {
    const double share = passed / (kSmoothing + passed);
    vx_ += share * ((tower.x - position_->x) / passed - vx_);
    vy_ += share * ((tower.y - position_->y) / passed - vy_);
  } else if (passed >= 1.0) {
    vx_ = vy_ = 0.0;
  }
  position_ = tower;
  time_ = time;
}

bool may_drive(const PlanarPose& pose, double forward, double radius, const Neighbour& other,
               double other_radius, const TrafficRules& rules) {
  if (!other.position() || forward == 0.0) return true;
  const double dx = other.position()->x - pose.x, dy = other.position()->y - pose.y;
  const double separation = std::hypot(dx, dy);
  if (!(separation > 0.0)) return false;
  const double mine =
      forward * (std::cos(pose.heading) * dx + std::sin(pose.heading) * dy) / separation;
  if (mine <= 0.0) return true;  // moves away from it
  const double its = -(other.vx() * dx + other.vy() * dy) / separation;
  const double least = radius + other_radius + rules.margin;
  if (separation - kForesight * (mine + std::max(0.0, its)) < least) return false;
  const bool approaching = its > kMoves;
  return !(rules.gives_way && approaching && separation < least + rules.caution);
}

}  // namespace box_carrier
