// Numbers with units in attributes: "24 14 4 cm", "24 cm 14 cm 4 cm", "0 ${y} 0".
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "values/value.h"

namespace cogrsim::dsl {

/// One entry, in SI units.
struct NumberEntry {
  double value = 0.0;
  Dimension dimension;
  bool bare = true;   ///< no unit: it has the expected dimension
  bool none = false;  ///< the word "none"
  bool poison = false;
  bool expression = false;
  std::size_t begin = 0, length = 0;  ///< bytes in the text, unit included
  std::size_t number_length = 0;      ///< without the unit
};

/// Evaluates the inside of a ${…} that begins at a byte of the text; faults are given with
/// positions in the whole text.
using ExpressionEvaluator = std::function<Value(std::string_view inside, std::size_t begin,
                                                std::optional<ExpressionFault>& fault)>;

struct NumberSyntax {
  bool dots = false;      ///< exactly two entries with ".." between them
  bool commas = false;    ///< entries may be followed by a comma or semicolon
  bool list_unit = true;  ///< one unit at the end goes for all
  bool glued = false;     ///< "3cm" is "3 cm", as on command lines
};

/// Bytes of the longest beginning that is a number, 0 for none: of "2e3" all, of "2eV" one.
std::size_t number_length(std::string_view text);

/// The help for a text that is nearly a number: "2m", "5 metres", "1,5", "$w",
/// "−1"; "" for all others.
std::string nearly_number_help(std::string_view text);

/// The help for a text with parameters outside ${…}: "write ${w}" for "$w", "{w}" and
/// "$(w)"; "" for all others. `number`: all of it is one number, "2*$w" being ${2*w}.
std::string braces_help(std::string_view text, bool number = false);

/// The text with "-" for what only looks like it, U+2212 and the dashes of print.
std::string plain_minus(std::string_view text);

/// Parses a text. On a fault the entries are useless.
std::vector<NumberEntry> parse_numbers(std::string_view text, const NumberSyntax& syntax,
                                       const ExpressionEvaluator& evaluate,
                                       std::optional<ExpressionFault>& fault);

/// Checks one entry against the expected dimension; `text` is what was parsed.
std::optional<ExpressionFault> check_dimension(const NumberEntry& entry, const Dimension& wanted,
                                               std::string_view text);

/// End of the ${…} that begins at `begin`: the byte behind its brace; npos when it does not end.
std::size_t expression_end(std::string_view text, std::size_t begin);

}  // namespace cogrsim::dsl
