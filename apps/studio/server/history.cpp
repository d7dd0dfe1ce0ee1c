#include "history.h"

#include <algorithm>

#include "cogrsim/physics/frame_memory.h"

namespace cogrsim::studio {

namespace {

/// At least so many frames stay, whatever memory they take.
constexpr std::size_t kFewest = 16;

std::size_t bytes_of(const Instant& instant) {
  return sizeof(Instant) + cogrsim::bytes_of(*instant.frame) +
         (instant.ghost ? cogrsim::bytes_of(*instant.ghost) : 0);
}

bool earlier(double time, const Instant& instant) { return time < instant.time(); }

}  // namespace

std::vector<Instant> History::add(Instant instant) {
  std::vector<Instant> gone;
  const std::size_t bytes = bytes_of(instant);
  std::lock_guard lock(mutex_);
  // Times increase; an instant that is not later than existing ones replaces them.
  while (!instants_.empty() && instants_.back().time() >= instant.time()) {
    bytes_ -= bytes_of(instants_.back());
    gone.push_back(std::move(instants_.back()));
    instants_.pop_back();
  }
  instants_.push_back(std::move(instant));
  bytes_ += bytes;
  if (bytes_ > limit_ && instants_.size() > kFewest) {
    for (Instant& thinned : thin()) gone.push_back(std::move(thinned));
  }
  return gone;
}

std::vector<Instant> History::thin() {
  std::vector<Instant> gone;
  const std::size_t half = instants_.size() / 2;
  std::size_t kept = 1;
  for (std::size_t i = 1; i < instants_.size(); ++i) {
    if (i < half && i % 2 == 1) {
      bytes_ -= bytes_of(instants_[i]);
      gone.push_back(std::move(instants_[i]));
    } else {
      if (kept != i) instants_[kept] = std::move(instants_[i]);
      ++kept;
    }
  }
  instants_.resize(kept);
  return gone;
}

std::vector<Instant> History::clear() {
  paths().clear();
  std::vector<Instant> gone;
  std::lock_guard lock(mutex_);
  gone.swap(instants_);
  bytes_ = 0;
  ++epoch_;
  return gone;
}

Frames::Extent History::extent() const {
  std::lock_guard lock(mutex_);
  if (instants_.empty()) return {};
  return {instants_.front().time(), instants_.back().time(), instants_.size()};
}

Instant History::at(double time) {
  std::lock_guard lock(mutex_);
  if (instants_.empty()) return {};
  const auto next = std::upper_bound(instants_.begin(), instants_.end(), time, earlier);
  return next == instants_.begin() ? instants_.front() : *std::prev(next);
}

Instant History::before(double time) {
  std::lock_guard lock(mutex_);
  const auto next = std::lower_bound(instants_.begin(), instants_.end(), time,
                                     [](const Instant& m, double t) { return m.time() < t; });
  return next == instants_.begin() ? Instant() : *std::prev(next);
}

std::vector<Instant> History::after(double time, std::size_t most) {
  std::lock_guard lock(mutex_);
  const auto first = std::upper_bound(instants_.begin(), instants_.end(), time, earlier);
  const auto count =
      std::min<std::ptrdiff_t>(instants_.end() - first, static_cast<std::ptrdiff_t>(most));
  return {first, first + count};
}

std::uint64_t History::epoch() const {
  std::lock_guard lock(mutex_);
  return epoch_;
}

}  // namespace cogrsim::studio
