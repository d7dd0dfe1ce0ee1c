// Reads what people type on the command line: numbers with units, lists, settings.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

enum class Dimension { time, length, angle };

struct Quantity {
  double value = 0.0;  ///< in s, m or rad
  Dimension dimension = Dimension::length;
};

/// A number, independent of the locale, that takes all of `text`. Errors: anything else, and what
/// is not finite.
Result<double> parse_number(const std::string& text);

/// "0.001", "1 ms", "2s", "1 min": seconds. Errors: no number, an unknown unit, not finite.
Result<double> parse_time(const std::string& text);

/// "5 mm", "0.01" (metres), "2 deg", "0.1 rad": a length or an angle; an angle needs its unit.
Result<Quantity> parse_length_or_angle(const std::string& text);

/// "name=value" into its two halves. Errors: no "=", no name.
Result<std::pair<std::string, std::string>> parse_setting(const std::string& text);

/// The pieces between `separator`s, without the blanks around them; empty pieces stay.
std::vector<std::string> split(const std::string& text, char separator);

}  // namespace cogrsim::cli
