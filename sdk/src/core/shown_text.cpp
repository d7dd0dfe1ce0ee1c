#include "cogrsim/core/shown_text.h"

#include <cstdint>
#include <cstdio>

#include "cogrsim/core/result.h"

namespace cogrsim {

namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 1;
  bool valid = false;
};

/// Decodes the character at `at` by RFC 3629: no overlong forms, surrogates or code points above
/// U+10FFFF.
CodePoint code_point(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const std::uint32_t first = byte(at);
  if (first < 0x80) return {first, 1, true};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return {};
  std::uint32_t value = first & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xC0u) != 0x80u) return {};
    value = value << 6u | (byte(at + i) & 0x3Fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool valid =
      value >= kLeast[bytes] && value <= 0x10FFFF && !(value >= 0xD800 && value <= 0xDFFF);
  return valid ? CodePoint{value, bytes, true} : CodePoint{};
}

bool steers(std::uint32_t c) {
  const auto within = [c](std::uint32_t low, std::uint32_t high) { return c >= low && c <= high; };
  return (c < 0x20 && c != '\n' && c != '\t') || within(0x7F, 0x9F) || c == 0x61C ||
         within(0x200E, 0x200F) || within(0x2028, 0x202E) || within(0x2060, 0x206F) ||
         c == 0xFEFF || within(0xFFF9, 0xFFFB) || within(0xE0000, 0xE0FFF);
}

}  // namespace

std::string printable(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const CodePoint c = code_point(text, at);
    if (c.valid && !steers(c.value)) {
      out.append(text, at, c.bytes);
    } else {
      out += kReplacement;
    }
    at += c.bytes;
  }
  return out;
}

std::string one_line(const std::string& text) {
  std::string out;
  for (const char c : printable(text)) {
    if (c == '\n' || c == '\t') {
      out += kReplacement;
    } else {
      out += c;
    }
  }
  return out;
}

std::string paragraph(const std::string& text) { return indented(printable(text)); }

std::string printable_json(const std::string& json) {
  std::string out;
  char escape[16];
  const auto put = [&](std::uint32_t unit) {
    std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(unit));
    out += escape;
  };
  for (std::size_t at = 0; at < json.size();) {
    const CodePoint c = code_point(json, at);
    if (c.valid && c.value >= 0x7F && steers(c.value)) {
      if (c.value > 0xFFFF) {
        put(0xD7C0 + (c.value >> 10u));
        put(0xDC00 + (c.value & 0x3FFu));
      } else {
        put(c.value);
      }
    } else {
      out.append(json, at, c.bytes);
    }
    at += c.bytes;
  }
  return out;
}

}  // namespace cogrsim
