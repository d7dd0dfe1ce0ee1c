// Character classes for the language's scanners.
#pragma once

#include <string>
#include <string_view>

#include "cogrsim/core/expression.h"

namespace cogrsim::dsl {

using expression::is_blank;
using expression::is_digit;
using expression::is_letter;

/// With small letters for the capitals of ASCII.
inline std::string small_letters(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

}  // namespace cogrsim::dsl
