#include "cogrsim/core/json_bounds.h"

#include <fmt/format.h>

namespace cogrsim {

std::string json_excess(std::string_view text, const JsonBounds& bounds) {
  std::size_t depth = 0, values = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c == '\\') ++i;
      if (c == '"') quoted = false;
      continue;
    }
    quoted = c == '"';
    const bool opens = c == '[' || c == '{';
    if (opens && ++depth > bounds.depth) return fmt::format("is nested deeper than {}", bounds.depth);
    if ((c == ']' || c == '}') && depth > 0) --depth;
    // Each value but the first follows one of these.
    if ((opens || c == ',') && ++values > bounds.values)
      return fmt::format("has more than {} values", bounds.values);
  }
  return {};
}

}  // namespace cogrsim
