// Typed parameters that plugins declare and scenes set.
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

/// A number list is flat: waypoints "0 0, 1 0" are four numbers.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

enum class ParameterType { boolean, integer, number, text, number_list };

/// "boolean", "integer", "number", "text", "number list".
COGRSIM_API const char* to_string(ParameterType type);

/// One declared parameter: its type is that of the default.
struct ParameterSpec {
  std::string name;
  ParameterValue default_value;
  std::string
      unit;  ///< SI unit of number and number list, as in the scene language; "" or "1": none
  std::string description;
  double minimum = -std::numeric_limits<double>::infinity();  ///< numbers, list elements [unit]
  double maximum = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};  ///< of a text; empty: any
  bool required = false;                  ///< the scene must set it

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

/// Declares a parameter; the literal decides the type (0.2 number, 3 integer, true boolean,
/// "left" text, std::vector<double>{} number list). A number without a unit is a plain one.
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

/// Values by name, in SI units.
using Parameters = std::map<std::string, ParameterValue>;

/// Checks `given` against `table` and fills in defaults; a whole number does for an integer, an
/// integer for a number, either for a list of one. Errors name the parameter, the expected type,
/// range or choices, and for an unknown name what there is; all of them, joined by newlines.
COGRSIM_API Result<Parameters> complete_parameters(const ParameterTable& table,
                                                   const Parameters& given);

/// The entry of `names` nearest to `word` (edit distance at most a third of its length, at least
/// 1), or "" when none is near.
COGRSIM_API std::string nearest_name(const std::string& word,
                                     const std::vector<std::string>& names);

}  // namespace cogrsim
