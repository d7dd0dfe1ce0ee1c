// Serialisation of numbers, texts and lists between two processes of one machine and one build.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace cogrsim {

/// Appends values to a buffer that is reused for the next message.
class WireWriter {
 public:
  explicit WireWriter(std::vector<char>& to) : to_(to) { to_.clear(); }

  template <class T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>, int> = 0>
  void put(T value) {
    bytes(&value, sizeof value);
  }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes(text.data(), text.size());
  }
  template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    bytes(values.data(), values.size() * sizeof(T));
  }
  void put(const std::vector<std::string>& texts) {
    put(static_cast<std::uint64_t>(texts.size()));
    for (const std::string& text : texts) put(text);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  void bytes(const void* from, std::size_t count) {
    const auto* begin = static_cast<const char*>(from);
    to_.insert(to_.end(), begin, begin + count);
  }

 private:
  std::vector<char>& to_;
};

/// Reads the output of a WireWriter. The data may be damaged: after the first inconsistency good()
/// is false and all further values are empty.
class WireReader {
 public:
  explicit WireReader(const std::vector<char>& from)
      : at_(from.data()), end_(from.data() + from.size()) {}

  bool good() const { return good_; }
  void spoil() { good_ = false; }

  template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
  void get(T& value) {
    // A bool must not get a value other than 0 or 1.
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      bytes(&byte, 1);
      value = byte != 0;
    } else {
      value = T{};
      bytes(&value, sizeof value);
    }
  }
  template <class T>
  T take() {
    T value{};
    get(value);
    return value;
  }
  void get(std::string& text) {
    text.clear();
    const std::size_t size = length(1);
    if (!good_) return;
    text.assign(at_, size);
    at_ += size;
  }
  template <class T, std::enable_if_t<std::is_arithmetic_v<T>, int> = 0>
  void get(std::vector<T>& values) {
    const std::size_t size = length(sizeof(T));
    values.resize(good_ ? size : 0);
    bytes(values.data(), values.size() * sizeof(T));
  }
  void get(std::vector<std::string>& texts) {
    texts.clear();
    const std::size_t size = length(sizeof(std::uint64_t));
    for (std::size_t i = 0; i < size && good_; ++i) get(texts.emplace_back());
  }
  template <class T>
  void get(std::optional<T>& value) {
    value.reset();
    if (take<bool>()) get(value.emplace());
  }
  void bytes(void* to, std::size_t count) {
    if (!good_ || static_cast<std::size_t>(end_ - at_) < count) {
      good_ = false;
      return;
    }
    if (count > 0) std::memcpy(to, at_, count);
    at_ += count;
  }
  /// Reads the number of entries that follow, each at least `least` bytes long. A number that
  /// exceeds the remaining data is an inconsistency.
  std::size_t length(std::size_t least) {
    const auto count = take<std::uint64_t>();
    if (good_ && count > static_cast<std::size_t>(end_ - at_) / least) good_ = false;
    return good_ ? static_cast<std::size_t>(count) : 0;
  }

 private:
  const char* at_;
  const char* end_;
  bool good_ = true;
};

}  // namespace cogrsim
