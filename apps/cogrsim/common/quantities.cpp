#include "common/quantities.h"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"

namespace cogrsim::cli {
namespace {

struct Unit {
  const char* name;
  double factor;
  Dimension dimension;
};

constexpr std::array<Unit, 17> kUnits = {{
    {"s", 1.0, Dimension::time},
    {"ms", 1e-3, Dimension::time},
    {"us", 1e-6, Dimension::time},
    {"µs", 1e-6, Dimension::time},
    {"ns", 1e-9, Dimension::time},
    {"min", 60.0, Dimension::time},
    {"h", 3600.0, Dimension::time},
    {"m", 1.0, Dimension::length},
    {"cm", 1e-2, Dimension::length},
    {"mm", 1e-3, Dimension::length},
    {"um", 1e-6, Dimension::length},
    {"µm", 1e-6, Dimension::length},
    {"nm", 1e-9, Dimension::length},
    {"km", 1e3, Dimension::length},
    {"rad", 1.0, Dimension::angle},
    {"mrad", 1e-3, Dimension::angle},
    {"deg", kPi / 180.0, Dimension::angle},
}};

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

// Splits "1.5 ms" into the number and the unit behind it.
Result<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  const std::string number = trimmed(text);
  // from_chars knows no leading plus sign, people do; "+-1" stays an error.
  const bool plus = number.size() > 1 && number[0] == '+' && number[1] != '-';
  const char* begin = number.data() + (plus ? 1 : 0);
  const char* end = number.data() + number.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || !std::isfinite(value)) {
    return fail(fmt::format("'{}' is not a number", text));
  }
  return std::make_pair(value, trimmed(std::string(rest, end)));
}

const Unit* find_unit(const std::string& name) {
  for (const Unit& unit : kUnits) {
    if (name == unit.name) return &unit;
  }
  return nullptr;
}

}  // namespace

Result<double> parse_number(const std::string& text) {
  const auto parts = number_and_unit(text);
  if (!parts) return tl::unexpected(parts.error());
  if (!parts->second.empty()) return fail(fmt::format("'{}' is not a number", text));
  return parts->first;
}

Result<double> parse_time(const std::string& text) {
  const auto parts = number_and_unit(text);
  if (!parts) {
    return fail(fmt::format("'{}' is not a time", text), "",
                "write a time such as \"1 ms\" or 0.001");
  }
  if (parts->second.empty()) return parts->first;
  const Unit* unit = find_unit(parts->second);
  if (unit == nullptr || unit->dimension != Dimension::time) {
    return fail(fmt::format("'{}' is not a time: unknown unit '{}'", text, parts->second), "",
                "units of time are ns, us, ms, s, min, h");
  }
  return parts->first * unit->factor;
}

Result<Quantity> parse_length_or_angle(const std::string& text) {
  const auto parts = number_and_unit(text);
  const char* hint = "write a length such as \"5 mm\" or an angle such as \"2 deg\"";
  if (!parts) return fail(fmt::format("'{}' is neither a length nor an angle", text), "", hint);
  if (parts->second.empty()) return Quantity{parts->first, Dimension::length};
  const Unit* unit = find_unit(parts->second);
  if (unit == nullptr || unit->dimension == Dimension::time) {
    return fail(fmt::format("'{}' is neither a length nor an angle: unknown unit '{}'", text,
                            parts->second),
                "", hint);
  }
  return Quantity{parts->first * unit->factor, unit->dimension};
}

Result<std::pair<std::string, std::string>> parse_setting(const std::string& text) {
  const auto equals = text.find('=');
  const std::string name = trimmed(text.substr(0, equals));
  if (equals == std::string::npos || name.empty()) {
    return fail(fmt::format("'{}' is not a setting", text), "",
                "write name=value, for example --set wheel_r=\"5 cm\"");
  }
  return std::make_pair(name, trimmed(text.substr(equals + 1)));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> arguments;
  std::size_t start = 0;
  while (true) {
    const auto end = text.find(separator, start);
    arguments.push_back(trimmed(text.substr(start, end - start)));
    if (end == std::string::npos) return arguments;
    start = end + 1;
  }
}

}  // namespace cogrsim::cli
