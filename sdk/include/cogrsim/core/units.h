// Units and dimensions as the scene language writes them, and numbers as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cogrsim/core/export.h"

namespace cogrsim::units {

/// Exponents of the base units; the angle is one of its own, so that degrees, radians and plain
/// numbers cannot be mixed up.
struct Dimension {
  std::int8_t m = 0, kg = 0, s = 0, ampere = 0, angle = 0, byte = 0;

  bool operator==(const Dimension& o) const {
    return m == o.m && kg == o.kg && s == o.s && ampere == o.ampere && angle == o.angle &&
           byte == o.byte;
  }
  bool operator!=(const Dimension& o) const { return !(*this == o); }
  bool none() const { return *this == Dimension{}; }
};

namespace dim {
inline constexpr Dimension kNone{};
inline constexpr Dimension kLength{1, 0, 0, 0, 0};
inline constexpr Dimension kMass{0, 1, 0, 0, 0};
inline constexpr Dimension kTime{0, 0, 1, 0, 0};
inline constexpr Dimension kAngle{0, 0, 0, 0, 1};
inline constexpr Dimension kSpeed{1, 0, -1, 0, 0};
inline constexpr Dimension kAcceleration{1, 0, -2, 0, 0};
inline constexpr Dimension kAngularSpeed{0, 0, -1, 0, 1};
inline constexpr Dimension kFrequency{0, 0, -1, 0, 0};
inline constexpr Dimension kDensity{-3, 1, 0, 0, 0};
inline constexpr Dimension kInertia{2, 1, 0, 0, 0};
inline constexpr Dimension kForce{1, 1, -2, 0, 0};
inline constexpr Dimension kTorque{2, 1, -2, 0, 0};
inline constexpr Dimension kStiffness{0, 1, -2, 0, 0};             // N/m
inline constexpr Dimension kAngularStiffness{2, 1, -2, 0, -1};     // N*m/rad
inline constexpr Dimension kDamping{0, 1, -1, 0, 0};               // N*s/m
inline constexpr Dimension kAngularDamping{2, 1, -1, 0, -1};       // N*m*s/rad
inline constexpr Dimension kIntegralGain{0, 1, -3, 0, 0};          // N/(m*s)
inline constexpr Dimension kAngularIntegralGain{2, 1, -3, 0, -1};  // N*m/(rad*s)
inline constexpr Dimension kVoltage{2, 1, -3, -1, 0};
inline constexpr Dimension kCurrent{0, 0, 0, 1, 0};
inline constexpr Dimension kResistance{2, 1, -3, -2, 0};
inline constexpr Dimension kTorqueConstant{2, 1, -2, -1, 0};  // N*m/A
inline constexpr Dimension kBackEmf{2, 1, -2, -1, -1};        // V*s/rad
inline constexpr Dimension kForceConstant{1, 1, -2, -1, 0};   // N/A, V*s/m
inline constexpr Dimension kMemory{0, 0, 0, 0, 0, 1};
}  // namespace dim

/// "an angle", "a length", "a plain number", "a quantity in kg*m/s".
COGRSIM_API std::string describe(const Dimension& dimension);
/// The SI unit as one would write it: "rad", "kg/m^3"; "" for a plain number.
COGRSIM_API std::string unit_of(const Dimension& dimension);
/// Whether a value of dimension `given` may stand for `wanted`. Equal; or, where mass is involved,
/// written without the angle ("N*m*s" for "N*m*s/rad"), since nothing can be confused there.
COGRSIM_API bool fits(const Dimension& given, const Dimension& wanted);

struct Unit {
  double above = 1.0, below = 1.0;  ///< to SI: times above, divided by below
  Dimension dimension;
  double to_si(double value) const { return value * above / below; }
};
/// Reads "kg/m^3", "N*m", "deg", "1/s"; nullopt: not a unit.
COGRSIM_API std::optional<Unit> parse_unit(std::string_view text);
/// The unit nearest to a misspelt one ("" when none is).
COGRSIM_API std::string nearest_unit(std::string_view text);

/// Reads a whole text as a finite number independently of the locale; nullopt for anything else,
/// "nan", "inf", "0x10", "12abc", "1,5" and "" included.
COGRSIM_API std::optional<double> parse_number(std::string_view text);
/// Shortest text that reads back as the same number.
COGRSIM_API std::string number_text(double value);

}  // namespace cogrsim::units
