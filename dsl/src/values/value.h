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
#include "cogrsim/core/units.h"

namespace cogrsim::dsl {

class Scope;

using units::describe;
using units::Dimension;
using units::fits;
using units::nearest_unit;
using units::number_text;
using units::parse_number;
using units::parse_unit;
using units::Unit;
using units::unit_of;
namespace dim = units::dim;

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

/// Longest text an expression makes [byte], and most entries of a list with the lists inside it.
inline constexpr std::size_t kLongestText = 1 << 16;
inline constexpr std::size_t kLongestList = 100000;
/// Work (see kMostWork in element.h) of a byte that an expression makes.
inline constexpr std::size_t kWorkOfValue = 8;

/// Bytes of text and 64 for each entry, of lists with the lists inside; counts no further than
/// `most`.
std::size_t size_of(const Value& value, std::size_t most);

/// What an expression can see.
struct Environment {
  const Scope* scope = nullptr;
  RandomStream* random = nullptr;  ///< nullptr: uniform and normal are refused here
  /// Work that may still be done; nullptr: no end.
  std::size_t* budget = nullptr;
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
