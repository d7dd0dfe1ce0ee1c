// Timer of an element with its own rate.
#pragma once

#include <cmath>
#include <cstdint>

namespace cogrsim {

/// The element is due at the first step boundary at or after k / rate, k = 0, 1, …. The mean rate
/// is exact for every period, because k is counted and times are not summed.
class RateTimer {
 public:
  RateTimer() = default;
  explicit RateTimer(double rate) : rate_(rate) {}  ///< [Hz]; 0: every step

  /// Whether the element is due. `dt` is the current time step [s]; a step boundary counts as
  /// reached up to a millionth of a step earlier.
  bool due(double time, double dt) const {
    return rate_ <= 0.0 || static_cast<double>(next_) <= (time + 1e-6 * dt) * rate_;
  }
  /// Must be called after due() returned true; ticks within a long step are skipped.
  void advance(double time, double dt) {
    if (rate_ > 0.0) {
      next_ = static_cast<std::uint64_t>(std::floor((time + 1e-6 * dt) * rate_)) + 1;
    }
  }
  /// Number of the next tick, for snapshots.
  std::uint64_t next() const { return next_; }
  void set_next(std::uint64_t next) { next_ = next; }
  /// Skips all ticks before `time`; a tick at `time` is still due.
  void skip_to(double time, double dt) {
    if (rate_ > 0.0) {
      next_ = static_cast<std::uint64_t>(std::fmax(0.0, std::ceil((time - 1e-6 * dt) * rate_)));
    }
  }
  /// Nominal period between two ticks [s].
  double period(double dt) const { return rate_ > 0.0 ? std::fmax(1.0 / rate_, dt) : dt; }

 private:
  double rate_ = 0.0;
  std::uint64_t next_ = 0;
};

}  // namespace cogrsim
