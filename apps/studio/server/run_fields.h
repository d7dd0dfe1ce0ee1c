// Reads the fields of a request; errors name the field.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "talk.h"

namespace cogrsim::studio::fields {

/// nullptr: left out, or null.
inline const Json* find(const Json& fields, const char* key) {
  const auto found = fields.find(key);
  return found == fields.end() || found->is_null() ? nullptr : &*found;
}

inline tl::unexpected<Error> wrong(const char* key, const std::string& expected) {
  return fail("'" + std::string(key) + "' must be " + expected);
}

/// Empty: left out, or null. Errors: no finite number.
inline Result<std::optional<double>> maybe_number(const Json& fields, const char* key) {
  const Json* value = find(fields, key);
  if (!value) return std::optional<double>();
  if (!value->is_number() || !std::isfinite(value->get<double>())) return wrong(key, "a number");
  return std::optional<double>(value->get<double>());
}

inline Result<double> number(const Json& fields, const char* key) {
  const auto value = maybe_number(fields, key);
  if (!value) return tl::unexpected(value.error());
  if (!*value) return wrong(key, "a number");
  return **value;
}

/// Whole, from `least` to `most`; `otherwise` where it is left out.
inline Result<std::int64_t> whole(const Json& fields, const char* key, std::int64_t otherwise,
                                  std::int64_t least, std::int64_t most) {
  const auto value = maybe_number(fields, key);
  if (!value) return tl::unexpected(value.error());
  if (!*value) return otherwise;
  const double v = **value;
  if (v != std::floor(v) || v < static_cast<double>(least) || v > static_cast<double>(most)) {
    return wrong(key,
                 "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  }
  return static_cast<std::int64_t>(v);
}

/// Empty: left out, or null.
inline Result<std::optional<std::string>> maybe_text(const Json& fields, const char* key) {
  const Json* value = find(fields, key);
  if (!value) return std::optional<std::string>();
  if (!value->is_string()) return wrong(key, "text");
  return std::optional<std::string>(value->get<std::string>());
}

inline Result<std::string> text(const Json& fields, const char* key) {
  const auto value = maybe_text(fields, key);
  if (!value) return tl::unexpected(value.error());
  if (!*value) return wrong(key, "text");
  return **value;
}

inline Result<bool> truth(const Json& fields, const char* key, bool otherwise) {
  const Json* value = find(fields, key);
  if (!value) return otherwise;
  if (!value->is_boolean()) return wrong(key, "true or false");
  return value->get<bool>();
}

}  // namespace cogrsim::studio::fields
