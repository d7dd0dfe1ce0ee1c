// When something with a rate of its own is due.
#pragma once

#include <cmath>
#include <cstdint>

namespace cogrsim {

/// Due at the first step boundary at or after k / rate, k = 0, 1, …: exact on average for any
/// period, because k is counted and never a sum of floating-point times.
class RateTimer {
 public:
  RateTimer() = default;
  explicit RateTimer(double rate) : rate_(rate) {}  ///< [Hz]; 0: every step

  /// `dt`: present step length [s]; boundaries a millionth of a step early count as reached.
  bool due(double time, double dt) const {
    return rate_ <= 0.0 || static_cast<double>(next_) <= (time + 1e-6 * dt) * rate_;
  }
  /// To be called after due() said yes; ticks that a long step jumped over are skipped.
  void advance(double time, double dt) {
    if (rate_ > 0.0) {
      next_ = static_cast<std::uint64_t>(std::floor((time + 1e-6 * dt) * rate_)) + 1;
    }
  }
  /// Number of the next tick, for snapshots; and back.
  std::uint64_t next() const { return next_; }
  void set_next(std::uint64_t next) { next_ = next; }
  /// As if all ticks before `time` were over; one that is due at `time` still is.
  void skip_to(double time, double dt) {
    if (rate_ > 0.0) {
      next_ = static_cast<std::uint64_t>(std::fmax(0.0, std::ceil((time - 1e-6 * dt) * rate_)));
    }
  }
  /// Nominal time between two ticks [s].
  double period(double dt) const { return rate_ > 0.0 ? std::fmax(1.0 / rate_, dt) : dt; }

 private:
  double rate_ = 0.0;
  std::uint64_t next_ = 0;
};

}  // namespace cogrsim
