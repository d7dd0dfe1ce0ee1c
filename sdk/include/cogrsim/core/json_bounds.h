// Bounds on JSON of strangers before it is parsed: a value takes some thirty times the memory of the
// two bytes that it may have in a text, and parsers are recursive.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "cogrsim/core/export.h"

namespace cogrsim {

struct JsonBounds {
  std::size_t depth = 64;         ///< of arrays and objects in one another
  std::size_t values = 200'000;  ///< about 20 MB, beside the texts
};

/// "is nested deeper than 64" or "has more than 200000 values"; empty: neither. Whether the text is
/// JSON is not checked.
COGRSIM_API std::string json_excess(std::string_view text, const JsonBounds& bounds = {});

}  // namespace cogrsim
