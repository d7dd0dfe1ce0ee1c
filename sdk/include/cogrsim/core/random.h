// Seeded random streams. There is no global source: each stream is keyed by the run's seed and the
// path of the element that draws, so that adding an element does not reshuffle the others.
#pragma once

#include <cstdint>
#include <string_view>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// 64-bit FNV-1a over `bytes` bytes, continued from `hash`.
COGRSIM_API std::uint64_t hash_bytes(const void* data, std::size_t bytes,
                                     std::uint64_t hash = 0xcbf29ce484222325ull);

/// splitmix64 (Steele, Lea, Flood 2014): the same numbers on every machine and library.
class COGRSIM_API RandomStream {
 public:
  /// `path`: dotted name of the element, e.g. "bot.robot.ir_2".
  RandomStream(std::uint64_t seed, std::string_view path);

  std::uint64_t next();
  /// Uniform in [low, high).
  double uniform(double low = 0.0, double high = 1.0);
  /// Gaussian by the Box-Muller transform; draws two numbers each time, so a stream has no memory
  /// besides its state.
  double normal(double mean = 0.0, double sigma = 1.0);

  std::uint64_t state() const { return state_; }
  void set_state(std::uint64_t state) { state_ = state; }

 private:
  std::uint64_t state_;
};

}  // namespace cogrsim
