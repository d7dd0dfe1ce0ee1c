// Units and dimensions of the scene language, and conversion between numbers and text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cogrsim/core/export.h"

namespace cogrsim::units {

/// Exponents of the base units. Angles are a base dimension of their own, so that degrees, radians
/// and dimensionless numbers cannot be confused.
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
inline constexpr Dimension kLinearDensity{-1, 1, 0, 0, 0};
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

/// Description for messages: "an angle", "a length", "a plain number", "a quantity in kg*m/s".
COGRSIM_API std::string describe(const Dimension& dimension);
/// The SI unit in its usual notation: "rad", "kg/m^3"; "" for a dimensionless number.
COGRSIM_API std::string unit_of(const Dimension& dimension);
/// Whether a value of dimension `given` is accepted where `wanted` is expected: the dimensions are
/// equal, or they involve mass and differ only in the angle ("N*m*s" for "N*m*s/rad"), which cannot
/// cause confusion.
COGRSIM_API bool fits(const Dimension& given, const Dimension& wanted);

/// A unit and its conversion to SI.
struct Unit {
  double above = 1.0, below = 1.0;  ///< SI value = value * above / below
  Dimension dimension;
  double to_si(double value) const { return value * above / below; }
};
/// Parses a unit such as "kg/m^3", "N*m", "deg" or "1/s"; nullopt if the text is not a unit.
COGRSIM_API std::optional<Unit> parse_unit(std::string_view text);
/// Unit of the product (`sign` '*') or quotient ('/') of quantities in the units `a` and `b` ("1":
/// none, "": unknown): the usual one of its dimension ("m/s" times "s" is "m"), or one made of both ("N*s").
COGRSIM_API std::string combined_unit(const std::string& a, char sign, const std::string& b);
/// The known unit most similar to a misspelt one, or "" if none is similar.
COGRSIM_API std::string nearest_unit(std::string_view text);

/// Parses the whole text as a finite decimal number, independently of the locale. Everything else
/// gives nullopt, for example "nan", "inf", "0x10", "12abc", "1,5" and "".
COGRSIM_API std::optional<double> parse_number(std::string_view text);
/// The shortest text that parse_number() converts back to exactly the same number.
COGRSIM_API std::string number_text(double value);

}  // namespace cogrsim::units
