// Mathematical constants used throughout CogRSim.
#pragma once

#include <limits>

namespace cogrsim {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Marks an unknown value where a number is expected.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace cogrsim
