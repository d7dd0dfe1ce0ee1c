// Conversion between numbers and little-endian byte strings, as in MCAP and protobuf.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace cogrsim::mcap {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "numbers are copied as they lie in memory; a big-endian machine must swap them");

template <class Number>
void put(std::string& out, Number value) {
  static_assert(std::is_arithmetic_v<Number>);
  char bytes[sizeof(Number)];
  std::memcpy(bytes, &value, sizeof(Number));
  out.append(bytes, sizeof(Number));
}

/// Overwrites the number at the offset `at` of `out`.
template <class Number>
void put_at(std::string& out, std::size_t at, Number value) {
  std::memcpy(&out[at], &value, sizeof(Number));
}

inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

/// Reads numbers and texts from untrusted bytes. After the first error good() is false and all
/// further values are zero or empty.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <class Number>
  Number number() {
    Number value{};
    const std::string_view taken = bytes(sizeof(Number));
    if (taken.size() == sizeof(Number)) std::memcpy(&value, taken.data(), sizeof(Number));
    return value;
  }
  std::string_view text() { return bytes(number<std::uint32_t>()); }
  std::string_view bytes(std::uint64_t count) {
    if (!good_ || count > bytes_.size()) {
      good_ = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(0, static_cast<std::size_t>(count));
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  std::string_view rest() const { return good_ ? bytes_ : std::string_view(); }
  bool empty() const { return !good_ || bytes_.empty(); }
  bool good() const { return good_; }

 private:
  std::string_view bytes_;
  bool good_ = true;
};

}  // namespace cogrsim::mcap
