// Seeded random streams. There is no global generator: each stream depends on the seed of the run
// and on the path of the element that draws from it, so that adding an element does not change the
// random numbers of the others.
#pragma once

#include <cstdint>
#include <string_view>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// 64-bit FNV-1a hash of `bytes` bytes at `data`, continued from `hash`.
COGRSIM_API std::uint64_t hash_bytes(const void* data, std::size_t bytes,
                                     std::uint64_t hash = 0xcbf29ce484222325ull);

/// Pseudo-random numbers by splitmix64 (Steele, Lea, Flood 2014). They are the same on every
/// machine and with every standard library. Not thread-safe.
class COGRSIM_API RandomStream {
 public:
  /// `path` is the dotted name of the element, e.g. "bot.robot.ir_2".
  RandomStream(std::uint64_t seed, std::string_view path);

  /// The next 64 random bits.
  std::uint64_t next();
  /// A number drawn uniformly from [low, high).
  double uniform(double low = 0.0, double high = 1.0);
  /// A normally distributed number by the Box-Muller transform. It always draws two uniform
  /// numbers, so that state() is the complete state of the stream.
  double normal(double mean = 0.0, double sigma = 1.0);

  std::uint64_t state() const { return state_; }
  void set_state(std::uint64_t state) { state_ = state; }

 private:
  std::uint64_t state_;
};

}  // namespace cogrsim
