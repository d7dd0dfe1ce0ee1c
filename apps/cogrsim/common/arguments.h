// Arguments of the command line that several subcommands take.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

// A wrong argument on the command line: what is wrong, and what to do.
class UsageError : public CLI::ValidationError {
 public:
  UsageError(const std::string& option, const cogrsim::Error& problem)
      : CLI::ValidationError(option, problem.text()) {}
};

/// The least time that is above 0 [s].
inline constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();
/// Any time, also a negative one [s].
inline constexpr double kAnyTime = std::numeric_limits<double>::infinity();

/// Time [s] of an option, from `least` to `most`; `help` says what the option expects. Throws
/// UsageError, as all here do.
double time_from(const std::string& option, const std::string& argument, double least = -kAnyTime,
                 double most = kAnyTime, const std::string& help = "");
/// Step length [s] of `--step`.
double step_from(const std::string& argument);
std::uint64_t seed_from(const std::string& argument);
/// An option that may be repeated, one argument at a time.
void add_list(CLI::App& command, const char* name, std::vector<std::string>& to, const char* text,
              const char* type);
/// `--json [FILE|-]`: `to` is a file, "-", which it is without one, or empty. `what` is its help.
CLI::Option* add_json(CLI::App& command, std::string& to,
                      const std::string& what = "Write the result as JSON");
/// Where JSON goes that `--format json`, which is `--json -`, may ask for, too; UsageError: both say something.
std::string json_from(const std::string& json, const std::string& format);
/// `--without`: what runs leave out.
void add_without(CLI::App& command, std::vector<std::string>& to);
/// The names in its arguments, see check_without().
std::vector<std::string> without_from(const std::vector<std::string>& arguments);
/// `--set NAME=VALUE`, each name once.
std::map<std::string, std::string> settings_from(const std::vector<std::string>& arguments);

/// The error for arguments that a subcommand does not know: the first of them, options first.
std::string unexpected_argument(const CLI::App& command,
                                const std::vector<std::string>& arguments);

}  // namespace cogrsim::cli
