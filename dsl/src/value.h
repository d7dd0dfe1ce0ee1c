// Values of the scene language: numbers with dimensions, and the expressions in ${…}.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cogrsim/core/random.h"

namespace cogrsim::dsl {

class Scope;

/// Exponents of the base units; the angle is one of its own, so that degrees, radians and plain
/// numbers cannot be mixed up.
struct Dimension {
  std::int8_t m = 0, kg = 0, s = 0, ampere = 0, angle = 0;

  bool operator==(const Dimension& o) const {
    return m == o.m && kg == o.kg && s == o.s && ampere == o.ampere && angle == o.angle;
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
}  // namespace dim

/// "an angle", "a length", "a plain number", "a quantity in kg*m/s".
std::string describe(const Dimension& dimension);
/// The SI unit as one would write it: "rad", "kg/m^3"; "" for a plain number.
std::string unit_of(const Dimension& dimension);
/// Whether a value of dimension `given` may stand for `wanted`. Equal; or, where mass is involved,
/// written without the angle ("N*m*s" for "N*m*s/rad"), since nothing can be confused there.
bool fits(const Dimension& given, const Dimension& wanted);

struct Unit {
  double above = 1.0, below = 1.0;  ///< to SI: times above, divided by below
  Dimension dimension;
  double to_si(double value) const { return value * above / below; }
};
/// Reads "kg/m^3", "N*m", "deg", "1/s"; nullopt: not a unit.
std::optional<Unit> parse_unit(std::string_view text);
/// The unit nearest to a misspelt one ("" when none is).
std::string nearest_unit(std::string_view text);

/// Reads a whole text as a finite number independently of the locale; nullopt for anything else,
/// "nan", "inf", "0x10", "12abc", "1,5" and "" included.
std::optional<double> parse_number(std::string_view text);
/// Shortest text that reads back as the same number.
std::string number_text(double value);

struct Quantity {
  double value = 0.0;  ///< SI
  Dimension dimension;
};

struct Value;
using ValueList = std::vector<Value>;

/// The result of an expression. Poison stands for "failed and reported": whatever it meets becomes
/// poison, silently.
struct Value {
  std::variant<std::monostate, Quantity, bool, std::string, std::shared_ptr<const ValueList>> data;

  static Value poison() { return {}; }
  static Value number(double value, Dimension dimension = {}) {
    return {Quantity{value, dimension}};
  }
  static Value boolean(bool value) { return {value}; }
  static Value text(std::string value) { return {std::move(value)}; }
  static Value list(ValueList values) {
    return {std::make_shared<const ValueList>(std::move(values))};
  }

  bool is_poison() const { return data.index() == 0; }
  const Quantity* as_number() const { return std::get_if<Quantity>(&data); }
  const bool* as_boolean() const { return std::get_if<bool>(&data); }
  const std::string* as_text() const { return std::get_if<std::string>(&data); }
  const ValueList* as_list() const {
    auto p = std::get_if<std::shared_ptr<const ValueList>>(&data);
    return p ? p->get() : nullptr;
  }
};

/// "a length", "a list of 3", "text", "true or false".
std::string describe(const Value& value);
/// As it is spliced into text: 3, 0.05, left, true, [1, 2].
std::string to_text(const Value& value);

/// What an expression can see.
struct Environment {
  const Scope* scope = nullptr;
  RandomStream* random = nullptr;  ///< nullptr: uniform and normal are refused here
};

/// A fault in an expression: code, where in its text, and what.
struct ExpressionFault {
  std::string code;
  std::size_t begin = 0, length = 1;  ///< bytes within the text given
  std::string message;
  std::string help;
};

/// Evaluates the inside of a ${…}. Total: no loops, bounded depth. On a fault the value is poison
/// and `fault` is set; poison without a fault came from poison in the scope.
Value evaluate(std::string_view expression, const Environment& environment,
               std::optional<ExpressionFault>& fault);

}  // namespace cogrsim::dsl
