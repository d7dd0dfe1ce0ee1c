// Quoting of untrusted text for gnuplot.
#include <cstdint>

#include <fmt/format.h>

#include "gnuplot_script.h"

namespace cogrsim::figures {
namespace {

// Length of the UTF-8 sequence at `at`; 0: not well-formed (RFC 3629: shortest form, no surrogates,
// up to U+10FFFF), or not a character of XML.
std::size_t utf8_length(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u;
  };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  std::uint32_t code = first & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0u) != 0x80u) return 0;
    code = (code << 6) | (byte(i) & 0x3fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool control = code < 0xa0;
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  const bool none = code == 0xfffe || code == 0xffff || code > 0x10ffff;
  return code < kLeast[length] || control || surrogate || none ? 0 : length;
}

bool harmless(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string(" .,:;()[]/+-=").find(c) != std::string::npos;
}

}  // namespace

std::string gnuplot_string(const std::string& text, bool lines) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '\n' || c == '\t' || c == '\r') {
      if (c == '\n' && lines)
        out += "\\n";
      else if (c != '\r')
        out += ' ';
      ++i;
      continue;
    }
    const std::size_t length = utf8_length(text, i);
    if (length == 0)
      out += "\xef\xbf\xbd";
    else if (length > 1 || harmless(c))
      out += text.substr(i, length);
    else
      out += fmt::format("\\{:03o}", static_cast<unsigned char>(c));
    i += length == 0 ? 1 : length;
  }
  return out + "\"";
}

}  // namespace cogrsim::figures
