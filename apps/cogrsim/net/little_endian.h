// Numbers as they go over the wire: the least significant byte first.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>

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

}  // namespace cogrsim::net
