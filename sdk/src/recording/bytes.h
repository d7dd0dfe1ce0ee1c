// Little-endian numbers in and out of byte strings, as MCAP and protobuf have them.
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

/// Overwrites the number at `at`, which is in `out` already.
template <class Number>
void put_at(std::string& out, std::size_t at, Number value) {
  std::memcpy(&out[at], &value, sizeof(Number));
}

inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

/// Takes numbers and texts off the front of bytes that nobody vouches for: once something does not
/// fit, good() is false and everything read is zero or empty.
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
