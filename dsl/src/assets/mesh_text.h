// Reading numbers out of lines of text, the same under every locale, and out of bytes.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace cogrsim::dsl {

/// Hands out the lines of a text one by one, without their ends; counts them from 1.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  int number() const { return number_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

/// Next word between blanks, taken off the front of `line`; empty at the end.
inline std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\v\f\r\n");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  const std::size_t end = std::min(line.find_first_of(" \t\v\f\r\n", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// A whole word as a finite number; a leading '+' is allowed, as exporters write it.
inline std::optional<double> to_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

inline std::optional<long long> to_integer(std::string_view word) {
  long long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// A number of the file, whose first byte is the lowest.
template <class Number>
Number read_little(const char* bytes) {
  std::uint32_t bits = 0;
  for (std::size_t i = sizeof(Number); i-- > 0;)
    bits = bits << 8 | static_cast<unsigned char>(bytes[i]);
  if constexpr (std::is_floating_point_v<Number>) {
    static_assert(sizeof(Number) == sizeof bits);
    Number value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  } else {
    static_assert(sizeof(Number) <= sizeof bits);
    return static_cast<Number>(bits);
  }
}

/// What a reader of meshes throws: what is wrong with the file.
struct BrokenMesh {
  std::string message;
};

/// The word in quotes, shortened and without unprintable bytes, for a message.
inline std::string quoted(std::string_view word) {
  std::string out = "'";
  for (const char c : word.substr(0, 40)) out += (c >= 32 && c < 127) ? c : '?';
  return out + (word.size() > 40 ? "…'" : "'");
}

}  // namespace cogrsim::dsl
