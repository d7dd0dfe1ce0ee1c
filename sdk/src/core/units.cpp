#include "cogrsim/core/units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/parameter.h"

namespace cogrsim::units {
namespace {

using namespace dim;

struct NamedUnit {
  const char* name;
  double above, below;  // 1 cm is 1/100 m: dividing keeps "57 cm" and 0.57 equal to the last bit
  Dimension dimension;
};

constexpr NamedUnit kUnits[] = {
    {"m", 1, 1, kLength},
    {"km", 1e3, 1, kLength},
    {"dm", 1, 10, kLength},
    {"cm", 1, 100, kLength},
    {"mm", 1, 1e3, kLength},
    {"um", 1, 1e6, kLength},
    {"in", 254, 1e4, kLength},
    {"ft", 3048, 1e4, kLength},
    {"kg", 1, 1, kMass},
    {"g", 1, 1e3, kMass},
    {"mg", 1, 1e6, kMass},
    {"t", 1e3, 1, kMass},
    {"s", 1, 1, kTime},
    {"ms", 1, 1e3, kTime},
    {"us", 1, 1e6, kTime},
    {"ns", 1, 1e9, kTime},
    {"min", 60, 1, kTime},
    {"h", 3600, 1, kTime},
    {"rad", 1, 1, kAngle},
    {"mrad", 1, 1e3, kAngle},
    {"deg", kPi, 180, kAngle},
    {"turn", 2 * kPi, 1, kAngle},
    {"rev", 2 * kPi, 1, kAngle},
    {"rpm", 2 * kPi, 60, kAngularSpeed},
    {"Hz", 1, 1, kFrequency},
    {"kHz", 1e3, 1, kFrequency},
    {"MHz", 1e6, 1, kFrequency},
    {"N", 1, 1, kForce},
    {"mN", 1, 1e3, kForce},
    {"kN", 1e3, 1, kForce},
    {"MN", 1e6, 1, kForce},
    {"J", 1, 1, kTorque},
    {"kJ", 1e3, 1, kTorque},
    {"W", 1, 1, Dimension{2, 1, -3, 0, 0}},
    {"mW", 1, 1e3, Dimension{2, 1, -3, 0, 0}},
    {"kW", 1e3, 1, Dimension{2, 1, -3, 0, 0}},
    {"Pa", 1, 1, Dimension{-1, 1, -2, 0, 0}},
    {"kPa", 1e3, 1, Dimension{-1, 1, -2, 0, 0}},
    {"MPa", 1e6, 1, Dimension{-1, 1, -2, 0, 0}},
    {"GPa", 1e9, 1, Dimension{-1, 1, -2, 0, 0}},
    {"A", 1, 1, kCurrent},
    {"mA", 1, 1e3, kCurrent},
    {"V", 1, 1, kVoltage},
    {"mV", 1, 1e3, kVoltage},
    {"kV", 1e3, 1, kVoltage},
    {"ohm", 1, 1, kResistance},
    {"mohm", 1, 1e3, kResistance},
    {"kohm", 1e3, 1, kResistance},
    {"B", 1, 1, kMemory},
    {"kB", 1e3, 1, kMemory},
    {"MB", 1e6, 1, kMemory},
    {"GB", 1e9, 1, kMemory},
    {"KiB", 1024, 1, kMemory},
    {"MiB", 1048576, 1, kMemory},
    {"GiB", 1073741824, 1, kMemory},
};

const NamedUnit* find_unit(std::string_view name) {
  for (const NamedUnit& u : kUnits) {
    if (name == u.name) return &u;
  }
  return nullptr;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Parses one factor such as "m" or "s^2" and moves `at` behind it.
bool read_factor(std::string_view text, std::size_t& at, Unit& out, bool divide) {
  const std::size_t begin = at;
  while (at < text.size() && is_letter(text[at])) ++at;
  const NamedUnit* unit = find_unit(text.substr(begin, at - begin));
  if (!unit) return false;
  int power = 1;
  if (at < text.size() && text[at] == '^') {
    ++at;
    bool negative = false;
    if (at < text.size() && text[at] == '-') {
      negative = true;
      ++at;
    }
    if (at >= text.size() || text[at] < '1' || text[at] > '9') return false;
    power = text[at++] - '0';
    if (negative) power = -power;
  }
  if (divide) power = -power;
  const auto add = [power](std::int8_t& to, std::int8_t exponent) {
    to = static_cast<std::int8_t>(std::clamp(to + exponent * power, -100, 100));
  };
  add(out.dimension.m, unit->dimension.m);
  add(out.dimension.kg, unit->dimension.kg);
  add(out.dimension.s, unit->dimension.s);
  add(out.dimension.ampere, unit->dimension.ampere);
  add(out.dimension.angle, unit->dimension.angle);
  add(out.dimension.byte, unit->dimension.byte);
  for (int i = std::abs(power); i > 0; --i) {
    out.above *= power > 0 ? unit->above : unit->below;
    out.below *= power > 0 ? unit->below : unit->above;
  }
  return true;
}

struct NamedDimension {
  Dimension dimension;
  const char* phrase;
  const char* unit;
};
constexpr NamedDimension kNames[] = {
    {kNone, "a plain number", ""},
    {kLength, "a length", "m"},
    {kMass, "a mass", "kg"},
    {kTime, "a time", "s"},
    {kAngle, "an angle", "rad"},
    {kSpeed, "a speed", "m/s"},
    {kAcceleration, "an acceleration", "m/s^2"},
    {kAngularSpeed, "an angular speed", "rad/s"},
    {Dimension{0, 0, -2, 0, 1}, "an angular acceleration", "rad/s^2"},
    {kFrequency, "a frequency", "Hz"},
    {kDensity, "a density", "kg/m^3"},
    {kLinearDensity, "a mass per length", "kg/m"},
    {kInertia, "a moment of inertia", "kg*m^2"},
    {kForce, "a force", "N"},
    {kTorque, "a torque", "N*m"},
    {kStiffness, "a stiffness", "N/m"},
    {kAngularStiffness, "an angular stiffness", "N*m/rad"},
    {kDamping, "a damping", "N*s/m"},
    {kAngularDamping, "an angular damping", "N*m*s/rad"},
    {kVoltage, "a voltage", "V"},
    {kCurrent, "a current", "A"},
    {kResistance, "a resistance", "ohm"},
    {kTorqueConstant, "a torque constant", "N*m/A"},
    {kBackEmf, "a back-EMF constant", "V*s/rad"},
    {kForceConstant, "a force constant", "N/A"},
    {kIntegralGain, "an integral gain", "N/(m*s)"},
    {kAngularIntegralGain, "an angular integral gain", "N*m/(rad*s)"},
    {Dimension{2, 0, 0, 0, 0}, "an area", "m^2"},
    {Dimension{3, 0, 0, 0, 0}, "a volume", "m^3"},
    {Dimension{-1, 1, -2, 0, 0}, "a pressure", "Pa"},
    {Dimension{2, 1, -3, 0, 0}, "a power", "W"},
    {kMemory, "an amount of memory", "B"},
};

/// Any dimension in base units: "kg*m/s^3".
std::string composed(const Dimension& d) {
  std::string above, below;
  int factors_below = 0;
  const auto add = [&](const char* name, int power) {
    if (power == 0) return;
    std::string& to = power > 0 ? above : below;
    if (!to.empty()) to += '*';
    to += name;
    if (std::abs(power) > 1) to += '^' + std::to_string(std::abs(power));
    if (power < 0) ++factors_below;
  };
  add("kg", d.kg);
  add("m", d.m);
  add("rad", d.angle);
  add("A", d.ampere);
  add("B", d.byte);
  add("s", d.s);
  if (below.empty()) return above;
  if (factors_below > 1) below = '(' + below + ')';
  return (above.empty() ? "1" : above) + "/" + below;
}

}  // namespace

std::string describe(const Dimension& dimension) {
  for (const NamedDimension& n : kNames) {
    if (n.dimension == dimension) return n.phrase;
  }
  return "a quantity in " + composed(dimension);
}

std::string unit_of(const Dimension& dimension) {
  for (const NamedDimension& n : kNames) {
    if (n.dimension == dimension) return n.unit;
  }
  return composed(dimension);
}

std::string combined_unit(const std::string& a, char sign, const std::string& b) {
  if (a.empty() || b.empty()) return "";
  if (b == "1") return a;
  if (a == b && sign == '/') return "1";
  const std::optional<Unit> left = a == "1" ? Unit{} : parse_unit(a), right = parse_unit(b);
  if (left && right) {
    Dimension d = left->dimension;
    const int power = sign == '*' ? 1 : -1;
    const auto add = [power](std::int8_t& to, int exponent) {
      to = static_cast<std::int8_t>(std::clamp(to + power * exponent, -100, 100));
    };
    add(d.m, right->dimension.m);
    add(d.kg, right->dimension.kg);
    add(d.s, right->dimension.s);
    add(d.ampere, right->dimension.ampere);
    add(d.angle, right->dimension.angle);
    add(d.byte, right->dimension.byte);
    if (d.none()) return "1";
    for (const NamedDimension& n : kNames) {
      if (n.dimension == d) return n.unit;
    }
  }
  if (sign == '/') return a + "/(" + b + ")";
  return a == "1" ? b : a + "*" + b;
}

bool fits(const Dimension& given, const Dimension& wanted) {
  if (given == wanted) return true;
  if (wanted.kg == 0 || given.angle != 0) return false;
  Dimension without = wanted;
  without.angle = 0;
  return given == without;
}

std::optional<Unit> parse_unit(std::string_view text) {
  Unit out;
  std::size_t at = 0;
  bool divide = false;
  if (text.size() > 2 && text[0] == '1' && text[1] == '/') {
    divide = true;
    at = 2;
  }
  while (true) {
    // A bracket below the line: "N/(m*s)".
    if (divide && at < text.size() && text[at] == '(') {
      ++at;
      while (true) {
        if (!read_factor(text, at, out, true)) return std::nullopt;
        if (at < text.size() && text[at] == '*') {
          ++at;
          continue;
        }
        break;
      }
      if (at >= text.size() || text[at] != ')') return std::nullopt;
      ++at;
    } else if (!read_factor(text, at, out, divide)) {
      return std::nullopt;
    }
    if (at == text.size()) return out;
    if (text[at] != '*' && text[at] != '/') return std::nullopt;
    divide = text[at] == '/';
    ++at;
  }
}

std::string nearest_unit(std::string_view text) {
  static const std::vector<std::pair<const char*, const char*>> kOthers = {
      {"degree", "deg"},  {"degrees", "deg"}, {"°", "deg"},        {"radian", "rad"},
      {"radians", "rad"}, {"Nm", "N*m"},      {"sec", "s"},        {"seconds", "s"},
      {"meter", "m"},     {"meters", "m"},    {"metre", "m"},      {"metres", "m"},
      {"inch", "in"},     {"hz", "Hz"},       {"Ohm", "ohm"},      {"Ω", "ohm"},
      {"newton", "N"},    {"kgs", "kg"},      {"Kg", "kg"},        {"KG", "kg"},
      {"RPM", "rpm"},     {"µm", "um"},       {"kg/m3", "kg/m^3"}, {"m/s2", "m/s^2"},
      {"Nms", "N*m*s"},   {"volt", "V"},      {"volts", "V"},      {"grams", "g"},
      {"M", "m"},         {"S", "s"},         {"CM", "cm"},        {"MM", "mm"}};
  for (const auto& [name, unit] : kOthers) {
    if (text == name) return unit;
  }
  if (text.size() < 2) return {};  // every single letter is similar to some unit
  std::vector<std::string> names;
  for (const NamedUnit& u : kUnits) names.emplace_back(u.name);
  return nearest_name(std::string(text), names);
}

std::optional<double> parse_number(std::string_view text) {
  if (text.empty()) return std::nullopt;
  std::string_view digits = text;
  // from_chars accepts no plus sign, but accepts "nan" and "inf".
  if (digits[0] == '+' || digits[0] == '-') digits.remove_prefix(1);
  if (digits.empty() || !((digits[0] >= '0' && digits[0] <= '9') || digits[0] == '.')) {
    return std::nullopt;
  }
  double value = 0.0;
  const auto end = digits.data() + digits.size();
  const auto [stop, fault] = std::from_chars(digits.data(), end, value);
  if (stop != end) return std::nullopt;
  if (fault == std::errc::result_out_of_range) {
    // Underflow gives 0; overflow is rejected.
    const bool tiny = digits.find("e-") != std::string_view::npos ||
                      digits.find("E-") != std::string_view::npos || digits[0] == '0' ||
                      digits[0] == '.';
    if (!tiny) return std::nullopt;
    value = 0.0;
  } else if (fault != std::errc{}) {
    return std::nullopt;
  }
  if (!std::isfinite(value)) return std::nullopt;
  return text[0] == '-' ? -value : value;
}

std::string number_text(double value) {
  char buffer[64];
  // The shortest text of 100000 is 1e+05, which is unexpected for a counter or in a name.
  const bool whole = value == std::floor(value) && std::abs(value) < 1e15;
  const auto [end, fault] =
      whole ? std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed)
            : std::to_chars(buffer, buffer + sizeof buffer, value);
  (void)fault;  // 64 bytes are enough for every double
  return std::string(buffer, end);
}

}  // namespace cogrsim::units
