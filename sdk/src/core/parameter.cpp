#include "cogrsim/core/parameter.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace cogrsim {
namespace {

/// Edit distance in which swapping two neighbours counts once (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    before = last;
    last = row;
  }
  return last[b.size()];
}

std::string with_unit(const ParameterSpec& spec, const std::string& number) {
  return spec.unit.empty() || spec.unit == "1" ? number : number + " " + spec.unit;
}

std::string range_text(const ParameterSpec& spec) {
  if (std::isinf(spec.maximum))
    return "at least " + with_unit(spec, fmt::format("{}", spec.minimum));
  if (std::isinf(spec.minimum))
    return "at most " + with_unit(spec, fmt::format("{}", spec.maximum));
  return with_unit(spec, fmt::format("{} to {}", spec.minimum, spec.maximum));
}

/// Checks the range of a number; returns an empty text if it is valid.
std::string check_number(const ParameterSpec& spec, double value) {
  if (std::isnan(value)) return fmt::format("parameter '{}' is not a number (NaN)", spec.name);
  if (value >= spec.minimum && value <= spec.maximum) return {};
  return fmt::format("parameter '{}' is {}, but must be {}", spec.name,
                     with_unit(spec, fmt::format("{}", value)), range_text(spec));
}

std::string check_text(const ParameterSpec& spec, const std::string& text) {
  if (spec.choices.empty() ||
      std::find(spec.choices.begin(), spec.choices.end(), text) != spec.choices.end()) {
    return {};
  }
  std::string out = fmt::format("parameter '{}' is '{}', but must be one of: {}", spec.name, text,
                                fmt::join(spec.choices, ", "));
  const std::string near = nearest_name(text, spec.choices);
  return near.empty() ? out : out + fmt::format(" (did you mean '{}'?)", near);
}
/// Converts a numeric value to the declared numeric type; a value that does not fit stays
/// unchanged. Programs that create models need not distinguish 3, 3.0 and a list of one number.
void convert(ParameterType wanted, ParameterValue& value) {
  // Above 2^53 a double no longer identifies one integer.
  constexpr double kLargestWhole = 9007199254740992.0;
  if (wanted == ParameterType::number || wanted == ParameterType::number_list) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) value = static_cast<double>(*whole);
  }
  const auto* number = std::get_if<double>(&value);
  if (number == nullptr) return;
  if (wanted == ParameterType::number_list) {
    value = std::vector<double>{*number};
  } else if (wanted == ParameterType::integer && *number == std::floor(*number) &&
             std::abs(*number) <= kLargestWhole) {
    value = static_cast<std::int64_t>(*number);
  }
}

/// Converts one value to the declared numeric type if necessary and checks it; returns an empty
/// text if it is valid.
std::string check_value(const ParameterSpec& spec, ParameterValue& value) {
  convert(spec.type(), value);
  if (spec.type() == ParameterType::integer && std::holds_alternative<double>(value)) {
    return fmt::format("parameter '{}' must be a whole number, not {}", spec.name,
                       std::get<double>(value));
  }
  if (value.index() != spec.default_value.index()) {
    return fmt::format("parameter '{}' must be of type {}, not {}", spec.name,
                       to_string(spec.type()),
                       to_string(static_cast<ParameterType>(value.index())));
  }
  switch (spec.type()) {
    case ParameterType::boolean:
      return {};
    case ParameterType::integer:
      return check_number(spec, static_cast<double>(std::get<std::int64_t>(value)));
    case ParameterType::number:
      return check_number(spec, std::get<double>(value));
    case ParameterType::text:
      return check_text(spec, std::get<std::string>(value));
    case ParameterType::number_list:
      for (double element : std::get<std::vector<double>>(value)) {
        std::string problem = check_number(spec, element);
        if (!problem.empty()) return problem;
      }
      return {};
  }
  return {};
}

std::string unknown_parameter(const ParameterTable& table, const std::string& name) {
  if (table.empty()) return fmt::format("unknown parameter '{}': there are none", name);
  std::vector<std::string> names;
  for (const ParameterSpec& spec : table) names.push_back(spec.name);
  std::string out =
      fmt::format("unknown parameter '{}': there are {}", name, fmt::join(names, ", "));
  const std::string near = nearest_name(name, names);
  return near.empty() ? out : out + fmt::format(" (did you mean '{}'?)", near);
}

}  // namespace

const char* to_string(ParameterType type) {
  switch (type) {
    case ParameterType::boolean:
      return "boolean";
    case ParameterType::integer:
      return "integer";
    case ParameterType::number:
      return "number";
    case ParameterType::text:
      return "text";
    case ParameterType::number_list:
      return "number list";
  }
  return "?";
}

Result<Parameters> complete_parameters(const ParameterTable& table, const Parameters& given) {
  Parameters out;
  std::vector<std::string> problems;
  for (const ParameterSpec& spec : table) {
    const auto found = given.find(spec.name);
    // Assigned, not constructed: the constructor of GCC 12 crashes if memory runs out while the
    // text of
  // a variant is copied.
    ParameterValue& value = out[spec.name];
    value = found == given.end() ? spec.default_value : found->second;
    if (found != given.end()) {
      std::string problem = check_value(spec, value);
      if (!problem.empty()) problems.push_back(std::move(problem));
    } else if (spec.required) {
      problems.push_back(fmt::format(
          "parameter '{}' must be set: {}", spec.name,
          spec.description.empty() ? to_string(spec.type()) : spec.description.c_str()));
    }
  }
  for (const auto& [name, value] : given) {
    if (out.count(name) == 0) problems.push_back(unknown_parameter(table, name));
  }
  if (!problems.empty()) return fail(fmt::format("{}", fmt::join(problems, "\n")));
  return out;
}

std::string nearest_name(const std::string& text, const std::vector<std::string>& names) {
  std::size_t best = std::max<std::size_t>(1, text.size() / 3) + 1;
  std::string nearest;
  for (const std::string& name : names) {
    // The distance is at least the difference in length; this also limits the computation.
    const std::size_t longer = std::max(name.size(), text.size());
    if (longer - std::min(name.size(), text.size()) >= best) continue;
    const std::size_t distance = edit_distance(text, name);
    if (distance < best) {
      best = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace cogrsim
