// Between sRGB as pictures have it and linear light.
#pragma once

#include <cstdint>

namespace cogrsim::osmesa {

/// One channel, 0 to 1 (IEC 61966-2-1).
double to_linear(double srgb);
double to_srgb(double linear);

/// The same from and to bytes, by table; encode(decode(b)) is b.
float decode(std::uint8_t srgb);
std::uint8_t encode(float linear);

}  // namespace cogrsim::osmesa
