// The Common Data Representation of OMG's DDS (version 1, little-endian), in which ROS 2 has its
// messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/types.h"
#include "recording/mcap/bytes.h"

namespace cogrsim::ros2 {

/// Appends a message to a string. Numbers are aligned to their size, counted from behind the four
/// bytes that say how they are encoded.
class Cdr {
 public:
  explicit Cdr(std::string& out) : out_(out) {
    constexpr char kLittleEndian[] = {0, 1, 0, 0};
    out_.append(kLittleEndian, sizeof kLittleEndian);
    start_ = out_.size();
  }

  template <class Number>
  void put(Number value) {
    align(sizeof value);
    mcap::put(out_, value);
  }
  void put(bool value) { put(static_cast<std::uint8_t>(value)); }
  void put(const Vec3& v) {
    for (int i = 0; i < 3; ++i) put(v[i]);
  }
  void put(const Quat& q) {
    for (const double part : {q.x(), q.y(), q.z(), q.w()}) put(part);
  }

  void text(std::string_view value) {
    count(value.size() + 1);
    out_.append(value);
    out_.push_back('\0');
  }
  /// Before the elements of a list.
  void count(std::size_t size) { put(static_cast<std::uint32_t>(size)); }
  template <class Number>
  void list(const std::vector<Number>& numbers) {
    count(numbers.size());
    for (const Number number : numbers) put(number);
  }
  void bytes(std::string_view value) {
    count(value.size());
    out_.append(value);
  }
  /// builtin_interfaces/Time.
  void time(std::uint64_t nanoseconds) {
    put(static_cast<std::int32_t>(nanoseconds / 1'000'000'000u));
    put(static_cast<std::uint32_t>(nanoseconds % 1'000'000'000u));
  }
  /// std_msgs/Header.
  void header(std::uint64_t nanoseconds, std::string_view frame_id) {
    time(nanoseconds);
    text(frame_id);
  }

 private:
  void align(std::size_t size) {
    const std::size_t over = (out_.size() - start_) % size;
    if (over != 0) out_.append(size - over, '\0');
  }

  std::string& out_;
  std::size_t start_;
};

}  // namespace cogrsim::ros2
