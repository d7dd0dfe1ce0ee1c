#include "common/arguments.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/physics/leave_out.h"
#include "common/options.h"
#include "common/quantities.h"

namespace cogrsim::cli {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

}  // namespace

double time_from(const std::string& option, const std::string& argument, double least, double most,
                 const std::string& help) {
  const auto time = parse_time(argument);
  if (!time) throw UsageError(option, time.error());
  if (*time < least || *time > most) {
    throw UsageError(option, Problem(fmt::format("'{}' is out of range", argument), "", help));
  }
  return *time;
}

double step_from(const std::string& argument) {
  return time_from("--step", argument, kSmallestStep, kLargestStep,
                   "a step is from 1 ns to 1 s; \"1 ms\" suits most scenes");
}

std::uint64_t seed_from(const std::string& argument) {
  std::uint64_t seed = 0;
  const char* const end = argument.data() + argument.size();
  const auto [rest, error] = std::from_chars(argument.data(), end, seed);
  if (error != std::errc{} || rest != end) {
    throw UsageError("--seed", Problem(fmt::format("'{}' is not a seed", argument), "",
                                       "write a whole number from 0 to 18446744073709551615"));
  }
  return seed;
}

std::map<std::string, std::string> settings_from(const std::vector<std::string>& arguments) {
  std::map<std::string, std::string> settings;
  for (const std::string& argument : arguments) {
    const auto setting = parse_setting(argument);
    if (!setting) throw UsageError("--set", setting.error());
    if (!settings.emplace(*setting).second) {
      throw UsageError("--set", Problem(fmt::format("'{}' is set twice", setting->first)));
    }
  }
  return settings;
}

CLI::Option* add_json(CLI::App& command, std::string& to, const std::string& what) {
  return command
      .add_option("--json", to,
                  what + " to a file; without one, or to -, on the standard output, which then has "
                         "nothing else")
      ->type_name("[FILE|-]")
      ->expected(0, 1)
      ->default_str("-");
}

std::string json_from(const std::string& json, const std::string& format) {
  if (!json.empty() && format != "text")
    throw UsageError("--format", Problem("--json says it, too", "", "leave out one of them"));
  return format == "json" ? "-" : json;
}

void add_without(CLI::App& command, std::vector<std::string>& to) {
  add_list(command, "--without", to,
           "Features of the scene that the run leaves out, with commas, as `cogrsim plugins` names "
           "them, or couplings, limits, loops, rotor-inertia; lacking: all that the engine lacks",
           "LIST|lacking");
}

std::vector<std::string> without_from(const std::vector<std::string>& arguments) {
  std::vector<std::string> names;
  for (const std::string& argument : arguments)
    for (const std::string& name : split(argument, ',')) names.push_back(name);
  if (const auto known = check_without(names); !known) throw UsageError("--without", known.error());
  return names;
}

void add_list(CLI::App& command, const char* name, std::vector<std::string>& to, const char* text,
              const char* type) {
  command.add_option(name, to, text)
      ->type_name(type)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::string unexpected_argument(const CLI::App& command,
                                const std::vector<std::string>& arguments) {
  const auto is_option = [](const std::string& text) { return text.size() > 1 && text[0] == '-'; };
  const auto found = std::find_if(arguments.begin(), arguments.end(), is_option);
  const std::string all = fmt::format("'cogrsim {} --help' lists all", command.get_name());
  if (found == arguments.end())
    return fmt::format("'{}' is an argument too many\nhelp: {}", arguments.front(), all);
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  const std::string wrong = found->substr(0, found->find('='));
  const std::string nearest = nearest_name(wrong, names);
  return fmt::format("there is no option '{}'\nhelp: {}{}", wrong,
                     nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest), all);
}

}  // namespace cogrsim::cli
