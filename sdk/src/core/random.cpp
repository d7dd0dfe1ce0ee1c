#include "cogrsim/core/random.h"

#include <cmath>

namespace cogrsim {
namespace {
constexpr double kTwoPi = 6.283185307179586476925;
}

std::uint64_t hash_bytes(const void* data, std::size_t bytes, std::uint64_t hash) {
  const auto* p = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; ++i) {
    hash ^= p[i];
    hash *= 0x100000001b3ull;
  }
  return hash;
}

RandomStream::RandomStream(std::uint64_t seed, std::string_view path) : state_(seed) {
  // The seed passes through the generator first, so that neighbouring seeds are uncorrelated.
  state_ = hash_bytes(path.data(), path.size(), 0xcbf29ce484222325ull ^ next());
}

std::uint64_t RandomStream::next() {
  state_ += 0x9e3779b97f4a7c15ull;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

double RandomStream::uniform(double low, double high) {
  const double unit = static_cast<double>(next() >> 11) * 0x1p-53;
  const double value = low + (high - low) * unit;
  // Rounding may give `high` if the interval is narrow.
  return value < high ? value : low;
}

double RandomStream::normal(double mean, double sigma) {
  const double u = 1.0 - uniform();  // (0, 1]: its logarithm is finite
  const double v = uniform();
  return mean + sigma * std::sqrt(-2.0 * std::log(u)) * std::cos(kTwoPi * v);
}

}  // namespace cogrsim
