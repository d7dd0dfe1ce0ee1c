// Reads fields that a request may leave out. What they are was checked: check_fields().
#pragma once

#include <optional>

#include "talk.h"

namespace cogrsim::studio::fields {

/// Empty: left out.
template <class Value>
std::optional<Value> maybe(const Json& fields, const char* key) {
  const auto found = fields.find(key);
  if (found == fields.end()) return std::nullopt;
  return found->get<Value>();
}

}  // namespace cogrsim::studio::fields
