// Typed parameters that plugins declare and that scenes set.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// Value of a parameter. A number list is flat: the waypoints "0 0, 1 0" are four numbers.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

enum class ParameterType { boolean, integer, number, text, number_list };

/// "boolean", "integer", "number", "text", "number list".
COGRSIM_API const char* to_string(ParameterType type);

/// Declaration of one parameter. Its type is the type of its default value.
struct ParameterSpec {
  std::string name;
  ParameterValue default_value;
  /// SI unit of a number or a number list, written as in the scene language; "" or "1": none.
  std::string unit;
  std::string description;
  /// Allowed range of a number, an integer and each element of a number list [unit], inclusive.
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};  ///< allowed values of a text; empty: any text
  bool required = false;                  ///< the scene must set the parameter

  ParameterType type() const { return static_cast<ParameterType>(default_value.index()); }

  ParameterSpec& range(double lowest, double highest) {
    minimum = lowest;
    maximum = highest;
    return *this;
  }
  ParameterSpec& one_of(std::vector<std::string> allowed) {
    choices = std::move(allowed);
    return *this;
  }
  ParameterSpec& must_be_set() {
    required = true;
    return *this;
  }
};

/// Declares a parameter. The type of the literal determines the type of the parameter: 0.2 is a
/// number, 3 an integer, true a boolean, "left" a text and std::vector<double>{} a number list. A
/// number without a unit is dimensionless.
inline ParameterSpec parameter(std::string name, double value, std::string unit, std::string text) {
  return {std::move(name), value, std::move(unit), std::move(text)};
}
inline ParameterSpec parameter(std::string name, double value, std::string text) {
  return {std::move(name), value, "", std::move(text)};
}
inline ParameterSpec parameter(std::string name, int value, std::string text) {
  return {std::move(name), std::int64_t{value}, "", std::move(text)};
}
inline ParameterSpec parameter(std::string name, bool value, std::string text) {
  return {std::move(name), value, "", std::move(text)};
}
inline ParameterSpec parameter(std::string name, const char* value, std::string text) {
  return {std::move(name), std::string(value), "", std::move(text)};
}
inline ParameterSpec parameter(std::string name, std::vector<double> value, std::string unit,
                               std::string text) {
  return {std::move(name), std::move(value), std::move(unit), std::move(text)};
}

using ParameterTable = std::vector<ParameterSpec>;

/// Parameter values by name, in SI units.
using Parameters = std::map<std::string, ParameterValue>;

/// A value of complete parameters, of the type that its table declares: `T` is bool, std::int64_t,
/// double, std::string or std::vector<double>.
template <class T>
const T& value_of(const Parameters& complete, const char* name) {
  return std::get<T>(complete.at(name));
}

/// Checks `given` against `table` and fills in the defaults. A number with an integral value is
/// accepted for an integer, an integer for a number, and either for a list of one element. The
/// error lists every problem on a line of its own: the parameter and the expected type, range or
/// choices, and for an unknown name the names that exist.
COGRSIM_API Result<Parameters> complete_parameters(const ParameterTable& table,
                                                   const Parameters& given);

/// The entry of `names` with the smallest edit distance to `text`, or "" if the distance of every
/// entry exceeds one third of the length of `text` (at least 1 is always allowed).
COGRSIM_API std::string nearest_name(const std::string& text,
                                     const std::vector<std::string>& names);

}  // namespace cogrsim
