#include "wheel_driver.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/algorithms/steering.h"
#include "cogrsim/core/constants.h"

namespace grid_navigator {

namespace {

using cogrsim::kPi;

// Over the length of a cell this is a lateral error of 2.5 cm, which the steering corrects.
constexpr double kAligned = 0.05;         // [rad]
constexpr double kAlignedRate = 1.0;      // [rad/s]
constexpr double kTurnGain = 8.0;         // on the move: turn rate per heading error [1/s]
constexpr double kSpotGain = 14.0;        // on the spot [1/s]
constexpr double kAsideGain = 4.0;        // heading per distance from the line [rad/m]
constexpr double kMaxAsideHeading = 0.3;  // [rad]
constexpr double kCentred = 0.05;         // [m]
constexpr double kProgress = 0.01;        // a smaller motion does not count as progress [m]

double towards(double value, double wanted, double change) {
  return value + std::clamp(wanted - value, -change, change);
}

}  // namespace

Cell neighbour(const Cell& cell, Action action) {
  switch (action) {
    case Action::north:
      return {cell.row + 1, cell.column};
    case Action::south:
      return {cell.row - 1, cell.column};
    case Action::east:
      return {cell.row, cell.column + 1};
    case Action::west:
      break;
  }
  return {cell.row, cell.column - 1};
}

double heading_of(Action action) {
  switch (action) {
    case Action::north:
      return kPi / 2;
    case Action::south:
      return -kPi / 2;
    case Action::east:
      return 0.0;
    case Action::west:
      break;
  }
  return kPi;
}

void Localiser::roll(double left, double right, double track) {
  const double turn = (right - left) / track, half = turn / 2;
  const double chord = (left + right) / 2 * (std::abs(half) > 1e-9 ? std::sin(half) / half : 1.0);
  pose_.x += chord * std::cos(pose_.heading + half);
  pose_.y += chord * std::sin(pose_.heading + half);
  pose_.heading = cogrsim::wrapped_angle(pose_.heading + turn);
}

void Localiser::correct(const PlanarPose& measured) {
  const double trust = started_ ? trust_ : 1.0;
  started_ = true;
  pose_.x += trust * (measured.x - pose_.x);
  pose_.y += trust * (measured.y - pose_.y);
  pose_.heading = cogrsim::wrapped_angle(
      pose_.heading + trust * cogrsim::wrapped_angle(measured.heading - pose_.heading));
}

void WheelDriver::start_in(const Cell& cell, const PlanarPose& pose) {
  from_ = to_ = cell;
  const double dx = (cell.column + 0.5) * settings_.cell - pose.x;
  const double dy = (cell.row + 0.5) * settings_.cell - pose.y;
  state_ = State::idle;
  if (std::max(std::abs(dx), std::abs(dy)) < kCentred) return;
  // A robot between two cells has an offset in one direction only.
  action_ = std::abs(dx) > std::abs(dy) ? (dx > 0 ? Action::east : Action::west)
                                        : (dy > 0 ? Action::north : Action::south);
  state_ = State::turning;
}

void WheelDriver::begin(Action action) {
  action_ = action;
  to_ = neighbour(from_, action);
  state_ = State::turning;
  blocked_ = false;
}

void WheelDriver::extend() {
  from_ = to_;
  to_ = neighbour(from_, action_);
  best_along_ += settings_.cell;
  ++finished_;
}

void WheelDriver::give_up() {
  if (state_ == State::turning) finish(true);
  if (state_ != State::driving) return;
  state_ = State::returning;
  waited_ = going_back_ = 0.0;
}

void WheelDriver::finish(bool blocked) {
  blocked_ = blocked;
  if (blocked) to_ = from_;
  from_ = to_;
  state_ = State::idle;
  ++finished_;
}

WheelDriver::Track WheelDriver::track_to(const Cell& cell, const PlanarPose& pose) const {
  const double dx = (cell.column + 0.5) * settings_.cell - pose.x;
  const double dy = (cell.row + 0.5) * settings_.cell - pose.y;
  const double c = std::cos(heading_of(action_)), s = std::sin(heading_of(action_));
  return {c * dx + s * dy, s * dx - c * dy};
}

bool WheelDriver::may_extend(const PlanarPose& pose) const {
  if (state_ != State::driving) return false;
  // Slightly before the point where it has to brake with `acceleration`, so that it does not slow
  // down.
  const double brake = now_.forward * now_.forward / (2 * settings_.acceleration);
  return track_to(to_, pose).along < brake + 0.05 * settings_.cell;
}

double WheelDriver::steer(const PlanarPose& pose, double aside, bool backwards) const {
  const double off = std::clamp(kAsideGain * aside, -kMaxAsideHeading, kMaxAsideHeading);
  const double wanted = heading_of(action_) + (backwards ? off : -off);
  return std::clamp(kTurnGain * cogrsim::wrapped_angle(wanted - pose.heading), -settings_.turn_rate,
                    settings_.turn_rate);
}

bool WheelDriver::pushed_in_vain(double along, double wanted, double period) {
  if (along < best_along_ - kProgress || wanted < 0.02) {
    best_along_ = std::min(best_along_, along);
    waited_ = 0.0;
    return false;
  }
  waited_ += period;
  return waited_ > settings_.patience;
}

Velocity WheelDriver::turn(const PlanarPose& pose) {
  const double error = cogrsim::wrapped_angle(heading_of(action_) - pose.heading);
  if (std::abs(error) < kAligned && std::abs(now_.turn) < kAlignedRate) {
    state_ = State::driving;
    waited_ = 0.0;
    best_along_ = track_to(to_, pose).along;
    return {};
  }
  // The fastest turn rate from which it can stop in time, linear near the end.
  const double size = std::min({settings_.turn_rate, kSpotGain * std::abs(error),
                                std::sqrt(2 * settings_.turn_acceleration * std::abs(error))});
  return {0.0, std::copysign(size, error)};
}

Velocity WheelDriver::drive(const PlanarPose& pose, double ahead, double speed, double period) {
  const Track left = track_to(to_, pose);
  if (left.along < settings_.arrival) {
    finish(false);
    return {};
  }
  // An obstacle ahead must leave enough clearance at the target.
  if (ahead < left.along + settings_.clearance) {
    give_up();
    return {};
  }
  const double forward = std::min(speed, std::sqrt(2 * settings_.acceleration * left.along));
  if (pushed_in_vain(left.along, now_.forward, period)) {
    give_up();
    return {};
  }
  return {forward, steer(pose, left.aside, false)};
}

Velocity WheelDriver::go_back(const PlanarPose& pose, double speed, double period) {
  const Track left = track_to(from_, pose);
  going_back_ += period;
  // If the robot is also blocked on its return, the next action starts from here.
  const bool stuck = going_back_ > 4 * settings_.patience;
  if (left.along > -settings_.arrival || stuck) {
    finish(true);
    return {};
  }
  const double backward =
      std::min(0.6 * speed, std::sqrt(2 * settings_.acceleration * -left.along));
  return {-backward, steer(pose, left.aside, true)};
}

Velocity WheelDriver::update(const PlanarPose& pose, double ahead, double speed, double period) {
  Velocity wanted;
  if (state_ == State::turning) wanted = turn(pose);
  if (state_ == State::driving) wanted = drive(pose, ahead, speed, period);
  if (state_ == State::returning) wanted = go_back(pose, speed, period);
  now_.forward = towards(now_.forward, wanted.forward, settings_.acceleration * period);
  now_.turn = towards(now_.turn, wanted.turn, settings_.turn_acceleration * period);
  return now_;
}

}  // namespace grid_navigator
