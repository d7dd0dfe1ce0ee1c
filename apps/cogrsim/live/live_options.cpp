#include "live/live_options.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include <fmt/format.h>

#include "common/arguments.h"

namespace cogrsim::cli {

LiveOptions live_from(const std::string& argument) {
  LiveOptions options;
  const auto wrong = [&] {
    return UsageError("--live",
                      Error(fmt::format("'{}' is not an address to listen at", argument), "",
                            "write an address of this machine with a port, such as 127.0.0.1:8765, "
                            "or nothing; a scene comes before --live"));
  };
  if (argument.empty()) return options;
  std::string host = argument, port;
  const auto colon = argument.rfind(':');
  const bool bracketed = argument.front() == '[';
  if (bracketed || std::count(argument.begin(), argument.end(), ':') == 1) {
    const auto end = bracketed ? argument.find(']') : colon;
    if (end == std::string::npos) throw wrong();
    host = bracketed ? argument.substr(1, end - 1) : argument.substr(0, end);
    const std::string rest = argument.substr(bracketed ? end + 1 : end);
    if (rest.size() == 1 || (!rest.empty() && rest.front() != ':')) throw wrong();
    if (!rest.empty()) port = rest.substr(1);
  } else if (argument.find_first_not_of("0123456789") == std::string::npos) {
    host.clear();
    port = argument;
  }
  if (!port.empty()) {
    unsigned int number = 0;
    const auto [rest, error] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (error != std::errc{} || rest != port.data() + port.size() || number < 1 || number > 65535) {
      throw wrong();
    }
    options.port = static_cast<unsigned short>(number);
  }
  if (!host.empty()) options.host = host;
  // An address alone, for names may lead anywhere.
  const auto is_part = [](char c) {
    return std::isxdigit(static_cast<unsigned char>(c)) || c == '.' || c == ':';
  };
  if (options.host != "localhost" &&
      !std::all_of(options.host.begin(), options.host.end(), is_part)) {
    throw wrong();
  }
  return options;
}

}  // namespace cogrsim::cli
