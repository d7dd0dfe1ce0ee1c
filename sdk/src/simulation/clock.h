// The clock of a run, and how fast it proceeds.
#pragma once

#include <cstdint>
#include <limits>

namespace cogrsim {

/// Counts steps: time = base_time + steps_since_base * dt, so that rounding errors do not accumulate.
class Clock {
 public:
  /// Part of snapshots.
  struct State {
    double dt = 1e-3;        ///< duration of the next step [s]
    double base_time = 0.0;  ///< time at which `dt` was set [s]
    double last_dt = 0.0;    ///< duration of the last step [s]; 0: there was none
    std::uint64_t steps = 0, steps_since_base = 0;
  };

  double time() const {
    return state_.base_time + static_cast<double>(state_.steps_since_base) * state_.dt;
  }
  double dt() const { return state_.dt; }
  double last_dt() const { return state_.last_dt; }
  std::uint64_t steps() const { return state_.steps; }

  /// Sets the duration of the steps from now on [s].
  void set_dt(double dt) {
    state_.base_time = time();
    state_.steps_since_base = 0;
    state_.dt = dt;
  }
  /// A step was made.
  void advance() {
    ++state_.steps;
    ++state_.steps_since_base;
    state_.last_dt = state_.dt;
  }
  /// Returns to time 0; the duration of the steps is unchanged.
  void restart() { state_ = {state_.dt}; }

  const State& save() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  State state_;
};

/// How fast a run proceeds, as its user sets it. Not part of snapshots.
struct Pace {
  double speed = std::numeric_limits<double>::infinity();  ///< see SetSpeed
  bool paused = false;
  bool single_step = false;  ///< make one step although paused
  bool waits() const { return paused && !single_step; }
};

}  // namespace cogrsim
