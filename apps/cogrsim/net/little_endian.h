// Numbers as they go over the wire: the least significant byte first.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace cogrsim::net {

template <class Number>
void put_number(std::string& out, Number value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  std::reverse(bytes, bytes + sizeof value);
#endif
  out.append(bytes, sizeof value);
}

/// Takes a number from the front of `bytes`; false: they are too short.
template <class Number>
bool take_number(std::string_view& bytes, Number& number) {
  if (bytes.size() < sizeof number) return false;
  number = 0;
  for (std::size_t i = sizeof number; i-- > 0;) {
    number = static_cast<Number>(number << 8 | static_cast<unsigned char>(bytes[i]));
  }
  bytes.remove_prefix(sizeof number);
  return true;
}

}  // namespace cogrsim::net
