// Words of the command line that several subcommands take.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

// A wrong word on the command line: what, and the way out.
class UsageError : public CLI::ValidationError {
 public:
  UsageError(const std::string& option, const cogrsim::Error& problem)
      : CLI::ValidationError(option, problem.text()) {}
};

/// Step length [s] of `--step`. Throws UsageError, as all here do.
double step_from(const std::string& word);
std::uint64_t seed_from(const std::string& word);
/// An option that may be repeated, one word at a time.
void add_list(CLI::App& command, const char* name, std::vector<std::string>& to, const char* text,
              const char* type);
/// `--set NAME=VALUE`, each name once.
std::map<std::string, std::string> settings_from(const std::vector<std::string>& words);

}  // namespace cogrsim::cli
