// Reads fields that a request may leave out. What they are was checked: check_fields().
#pragma once

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>

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

namespace cogrsim::studio {

/// A name of a backend, never a path.
inline Result<> check_plugin_name(const std::string& name) {
  const bool plain = !name.empty() && name.size() <= 100 &&
                     std::all_of(name.begin(), name.end(), [](unsigned char c) {
                       return std::isalnum(c) != 0 || c == '_' || c == '-';
                     });
  if (!plain) return fail("'name' must be the name of a backend");
  return {};
}

}  // namespace cogrsim::studio
