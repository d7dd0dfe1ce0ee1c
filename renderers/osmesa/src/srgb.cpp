#include "srgb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cogrsim::osmesa {

double to_linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double to_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

float decode(std::uint8_t srgb) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> out{};
    for (std::size_t i = 0; i < 256; ++i) {
      out[i] = static_cast<float>(to_linear(static_cast<double>(i) / 255.0));
    }
    return out;
  }();
  return table[srgb];
}

std::uint8_t encode(float linear) {
  // Fine enough that decode(b) comes back as b: bytes are at least 3e-4 apart in linear light.
  constexpr std::size_t kSteps = 16384;
  static const std::array<std::uint8_t, kSteps + 1> table = [] {
    std::array<std::uint8_t, kSteps + 1> out{};
    for (std::size_t i = 0; i <= kSteps; ++i) {
      out[i] =
          static_cast<std::uint8_t>(std::lround(255.0 * to_srgb(static_cast<double>(i) / kSteps)));
    }
    return out;
  }();
  const float clamped = std::clamp(linear, 0.0F, 1.0F);
  return table[static_cast<std::size_t>(clamped * static_cast<float>(kSteps) + 0.5F)];
}

}  // namespace cogrsim::osmesa
