#include "cogrsim/physics/backend_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "cogrsim/core/units.h"
#include "core/trimmed.h"

namespace cogrsim {
namespace {

constexpr const char* kBlanks = " \t\r\n";
constexpr const char* kHowTo = "write for example bullet(solver=dantzig iterations=50)";

/// Parses a number with or without a unit that matches the parameter; nullopt if it is none.
std::optional<double> number_of(const std::string& text, const std::string& unit) {
  if (const auto plain = units::parse_number(text)) return plain;
  const auto split = text.find_first_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ%");
  for (std::size_t at = split; at != std::string::npos && at > 0;
       at = text.find_first_not_of("0123456789.+-", at + 1)) {
    const auto value = units::parse_number(trimmed(text.substr(0, at)));
    const auto given = units::parse_unit(trimmed(text.substr(at)));
    if (!value || !given) continue;
    const auto wanted = units::parse_unit(unit);
    if (!units::fits(given->dimension, wanted ? wanted->dimension : units::dim::kNone)) return {};
    return given->to_si(*value);
  }
  return {};
}

/// Converts the text to the type of the parameter. A text that cannot be converted is returned
/// unchanged, so that complete_parameters() reports the expected type.
ParameterValue value_of(const ParameterSpec& spec, const std::string& text) {
  switch (spec.type()) {
    case ParameterType::boolean:
      if (text == "true" || text == "false") return text == "true";
      return text;
    case ParameterType::integer:
    case ParameterType::number:
      if (const auto number = number_of(text, spec.unit)) return *number;
      return text;
    case ParameterType::number_list: {
      std::vector<double> numbers;
      std::size_t at = 0;
      while ((at = text.find_first_not_of("; ", at)) != std::string::npos) {
        const auto end = std::min(text.find_first_of("; ", at), text.size());
        const auto number = units::parse_number(text.substr(at, end - at));
        if (!number) return text;
        numbers.push_back(*number);
        at = end;
      }
      return numbers;
    }
    case ParameterType::text:
      return text;
  }
  return text;
}

}  // namespace

Result<BackendChoice> parse_backend_choice(const std::string& text) {
  const auto refuse = [&](const std::string& why) {
    return fail(fmt::format("backend '{}': {}", text, why), "", kHowTo);
  };
  BackendChoice out;
  const auto open = text.find('(');
  out.name = trimmed(text.substr(0, open));
  if (out.name.empty()) return refuse("it has no name");
  if (open == std::string::npos) {
    if (text.find(')') != std::string::npos) return refuse("a bracket is not opened");
    return out;
  }
  const auto close = text.find(')', open);
  if (close == std::string::npos) return refuse("a bracket is not closed");
  if (!trimmed(text.substr(close + 1)).empty()) return refuse("something follows its options");
  const std::string inside = text.substr(open + 1, close - open - 1);
  // The name is before each '='; the value extends to the name of the next option.
  std::size_t at = inside.find_first_not_of(" \t\r\n,");
  while (at != std::string::npos) {
    const auto equals = inside.find('=', at);
    const std::string name = trimmed(inside.substr(at, equals - at));
    if (equals == std::string::npos || name.find_first_of(" \t\r\n,") != std::string::npos) {
      return refuse(fmt::format("'{}' has no value", name.substr(0, name.find_first_of(kBlanks))));
    }
    if (name.empty()) return refuse("an option has no name");
    const auto next = inside.find('=', equals + 1);
    std::size_t end = inside.size();
    if (next != std::string::npos) {
      const auto last = inside.find_last_not_of(kBlanks, next - 1);
      end = inside.find_last_of(" \t\r\n,", last);
      if (end == std::string::npos || end <= equals) return refuse("an option has no name");
    }
    std::string value = trimmed(inside.substr(equals + 1, end - equals - 1));
    while (!value.empty() && value.back() == ',')
      value = trimmed(value.substr(0, value.size() - 1));
    if (value.empty()) return refuse(fmt::format("'{}' has no value", name));
    if (!out.options.emplace(name, value).second) {
      return refuse(fmt::format("'{}' is given twice", name));
    }
    at = next == std::string::npos ? next : inside.find_first_not_of(" \t\r\n,", end);
  }
  return out;
}

std::vector<std::string> split_backend_choices(const std::string& text) {
  std::vector<std::string> out;
  std::string choice;
  int depth = 0;
  const auto finish = [&] {
    if (!choice.empty()) out.push_back(choice);
    choice.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '(') ++depth;
    if (c == ')' && depth > 0) --depth;
    const bool blank = std::string(kBlanks).find(c) != std::string::npos;
    if (depth == 0 && (c == ',' || blank)) {
      // "bullet (iterations=50)" is one choice.
      const auto next = blank ? text.find_first_not_of(kBlanks, i) : std::string::npos;
      if (next != std::string::npos && text[next] == '(' && !choice.empty()) continue;
      finish();
    } else {
      choice += c;
    }
  }
  finish();
  return out;
}

Result<Parameters> option_values(const BackendChoice& choice, const ParameterTable& table) {
  Parameters given;
  if (choice.options.empty()) return given;
  for (const auto& [name, text] : choice.options) {
    const auto spec = std::find_if(table.begin(), table.end(),
                                   [&](const ParameterSpec& s) { return s.name == name; });
    given[name] = spec == table.end() ? ParameterValue(text) : value_of(*spec, text);
  }
  ParameterTable optional = table;
  for (ParameterSpec& spec : optional) spec.required = false;
  if (auto complete = complete_parameters(optional, given); !complete) {
    return fail(fmt::format("options of backend '{}': {}", choice.name, complete.error().message));
  } else {
    for (auto& [name, value] : given) value = complete->at(name);
  }
  return given;
}

}  // namespace cogrsim
