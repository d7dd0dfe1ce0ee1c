// cogrsim test: the tests of scenes, on every backend and seed.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "common/json_text.h"

namespace CLI {
class App;
}

namespace cogrsim::cli {

/// Adds the subcommand; `status` receives the exit status when it runs.
void add_test(CLI::App& app, int& status);

struct TestCommandOptions {
  std::vector<std::string> scenes;  ///< files and folders
  std::vector<std::string> backends;
  std::vector<std::uint64_t> seeds;
  std::map<std::string, std::string> set;
  std::vector<std::string> plugin_paths, without;
  std::string filter;  ///< part of a test's name
  std::string junit;   ///< file
  std::string json;  ///< file, "-" or empty
  std::string out = "cogrsim-tests";  ///< folder of recordings
  int jobs = 0;                       ///< 0: as many as there are processors
  double timeout = 0.0;               ///< of a case, in wall-clock time [s]; 0: none
};

int test_command(const TestCommandOptions& options);

/// A test with one seed on one backend, or on those that must agree.
struct TestCase {
  std::string scene, test;
  std::size_t index = 0;  ///< of the test in its scene
  std::vector<std::string> backends;
  std::optional<std::uint64_t> seed;  ///< empty: the scene's
  std::uint64_t seed_used = 1;
  Json result;  ///< see test_case.h
  double wall_time = 0.0;

  /// "parks [bullet, seed 3]".
  std::string title() const;
  bool passed() const { return result.is_object() && result["status"] == "passed"; }
};

// ---- test_report.cpp

/// What its engines left out, a line each.
std::string left_out_text(const TestCase& one);
/// Faults of a case's run, a line each; also those that the test does not check.
std::string errors_text(const TestCase& one);
/// The failure and the command that repeats it; empty for a case that passed.
std::string failure_text(const TestCase& one, const TestCommandOptions& options);
/// JUnit's XML as CI systems read it: a suite per scene, a case per case.
std::string junit_text(const std::vector<TestCase>& cases);
Json report_json(const std::vector<TestCase>& cases, const TestCommandOptions& options);

// ---- test_pool.cpp

/// Runs all in processes of their own, `jobs` at a time; `done` is called with each in the order of
/// `cases`, `progress` of how many have ended. Errors: no process, an interrupt.
Result<> run_cases(std::vector<TestCase>& cases, const TestCommandOptions& options,
                   const std::function<void(const TestCase&)>& done,
                   const std::function<void(std::size_t ended, std::size_t failed)>& progress);

}  // namespace cogrsim::cli
