#include "history.h"

#include <algorithm>

namespace cogrsim::studio {

namespace {

/// So many frames stay whatever they take: less would be no history.
constexpr std::size_t kFewest = 16;

std::size_t bytes_of(const Moment& moment) {
  return sizeof(Moment) + studio::bytes_of(*moment.frame) +
         (moment.ghost ? studio::bytes_of(*moment.ghost) : 0);
}

bool earlier(double time, const Moment& moment) { return time < moment.time(); }

}  // namespace

std::size_t bytes_of(const Frame& frame) {
  std::size_t bytes = sizeof(Frame);
  bytes += frame.state.poses.size() * sizeof(Pose) + frame.state.twists.size() * sizeof(Twist);
  bytes += (frame.state.joint_positions.size() + frame.state.joint_velocities.size() +
            frame.state.joint_efforts.size() + frame.state.motor_efforts.size()) *
           sizeof(double);
  bytes += frame.accelerations.size() * sizeof(Twist) + frame.contacts.size() * sizeof(Contact) +
           frame.joint_reactions.size() * sizeof(Wrench) + frame.events.size() * sizeof(Event);
  for (const Reading& reading : frame.readings) {
    bytes += sizeof(Reading) + reading.values.size() * sizeof(double) +
             reading.contacts.size() * sizeof(Contact);
  }
  for (const auto* outputs : {&frame.controller_outputs, &frame.supervisor_outputs}) {
    for (const auto& values : *outputs) bytes += sizeof(values) + values.size() * sizeof(double);
  }
  return bytes;
}

std::vector<Moment> History::add(Moment moment) {
  std::vector<Moment> gone;
  const std::size_t bytes = bytes_of(moment);
  std::lock_guard lock(mutex_);
  // Time goes up; what is not later than what there is takes its place.
  while (!moments_.empty() && moments_.back().time() >= moment.time()) {
    bytes_ -= bytes_of(moments_.back());
    gone.push_back(std::move(moments_.back()));
    moments_.pop_back();
  }
  moments_.push_back(std::move(moment));
  bytes_ += bytes;
  if (bytes_ > limit_ && moments_.size() > kFewest) {
    for (Moment& thinned : thin()) gone.push_back(std::move(thinned));
  }
  return gone;
}

std::vector<Moment> History::thin() {
  std::vector<Moment> gone;
  const std::size_t half = moments_.size() / 2;
  std::size_t kept = 1;
  for (std::size_t i = 1; i < moments_.size(); ++i) {
    if (i < half && i % 2 == 1) {
      bytes_ -= bytes_of(moments_[i]);
      gone.push_back(std::move(moments_[i]));
    } else {
      if (kept != i) moments_[kept] = std::move(moments_[i]);
      ++kept;
    }
  }
  moments_.resize(kept);
  return gone;
}

std::vector<Moment> History::clear() {
  paths().clear();
  std::vector<Moment> gone;
  std::lock_guard lock(mutex_);
  gone.swap(moments_);
  bytes_ = 0;
  ++epoch_;
  return gone;
}

Frames::Extent History::extent() const {
  std::lock_guard lock(mutex_);
  if (moments_.empty()) return {};
  return {moments_.front().time(), moments_.back().time(), moments_.size()};
}

Moment History::at(double time) {
  std::lock_guard lock(mutex_);
  if (moments_.empty()) return {};
  const auto next = std::upper_bound(moments_.begin(), moments_.end(), time, earlier);
  return next == moments_.begin() ? moments_.front() : *std::prev(next);
}

Moment History::before(double time) {
  std::lock_guard lock(mutex_);
  const auto next = std::lower_bound(moments_.begin(), moments_.end(), time,
                                     [](const Moment& m, double t) { return m.time() < t; });
  return next == moments_.begin() ? Moment() : *std::prev(next);
}

std::vector<Moment> History::after(double time, std::size_t most) {
  std::lock_guard lock(mutex_);
  const auto first = std::upper_bound(moments_.begin(), moments_.end(), time, earlier);
  const auto count =
      std::min<std::ptrdiff_t>(moments_.end() - first, static_cast<std::ptrdiff_t>(most));
  return {first, first + count};
}

std::uint64_t History::epoch() const {
  std::lock_guard lock(mutex_);
  return epoch_;
}

}  // namespace cogrsim::studio
