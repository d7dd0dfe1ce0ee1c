// Runs the conformance tests on one backend and compares every outcome with the committed table.
//
//   cogrsim_conformance --backend bullet                     compare; exit 0: as the table says
//   cogrsim_conformance --backend bullet --figures [pendulum]   show what was measured
//   cogrsim_conformance --backend bullet --update            rewrite the table
//   cogrsim_conformance --backend bullet --option solver=dantzig   with that set in all scenes
//   cogrsim_conformance --backend bullet --mutate gravity=1.01  exit 0: some test turned red
//
// Exit status: 0 as expected, 1 something differs, 2 wrong usage or no such backend.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "cogrsim/plugin/loader.h"
#include "expectations.h"
#include "generated_tests.h"
#include "mutation.h"
#include "optioned.h"
#include "support.h"

namespace {

using namespace conformance;

struct Options {
  std::string backend;
  std::vector<std::string> plugin_paths;
  std::string against;
  std::string expectations;
  std::string mutate;
  std::string option;
  bool figures = false;
  bool update = false;
};

// State that the reporter, which Catch constructs, needs from main().
struct Run {
  Options options;
  ExpectationTable table;
  int tests = 0;
  int changes = 0;               // outcomes that differ from the table
  std::vector<std::string> red;  // passes in the table, fails now
};
Run* the_run = nullptr;

class TableReporter : public Catch::StreamingReporterBase<TableReporter> {
 public:
  using StreamingReporterBase::StreamingReporterBase;
  static std::string getDescription() { return "one line per test, compared with the table"; }

  void testCaseStarting(const Catch::TestCaseInfo& info) override {
    StreamingReporterBase::testCaseStarting(info);
    current() = Outcome();
    details_.clear();
    start_ = std::chrono::steady_clock::now();
  }

  void assertionStarting(const Catch::AssertionInfo&) override {}

  bool assertionEnded(const Catch::AssertionStats& stats) override {
    if (stats.assertionResult.isOk()) return true;
    if (current().status == Status::unsupported) return true;
    current().status = Status::fail;
    std::string text;
    for (const Catch::MessageInfo& message : stats.infoMessages) {
      // Figures are reported once each, with their worst value.
      if (message.message.rfind("figure: ", 0) == 0) return true;
      text += "      " + message.message + "\n";
    }
    const Catch::AssertionResult& result = stats.assertionResult;
    text += "      " + result.getExpressionInMacro();
    if (result.hasExpandedExpression()) text += "  with  " + result.getExpandedExpression();
    if (result.hasMessage()) text += "  " + result.getMessage();
    const Catch::SourceLineInfo place = result.getSourceInfo();
    text += std::string("  (") + place.file + ":" + std::to_string(place.line) + ")\n";
    current().failures.push_back(text);
    details_ += text;
    return true;
  }

  void testCaseEnded(const Catch::TestCaseStats& stats) override {
    StreamingReporterBase::testCaseEnded(stats);
    const std::string& name = stats.testInfo.name;
    const Outcome& outcome = current();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
    ++the_run->tests;
    const std::string change = the_run->table.compare(name, outcome);
    if (!change.empty()) ++the_run->changes;
    const Expectation* expected = the_run->table.find(name);
    if (outcome.status == Status::fail && expected && expected->status == Status::pass) {
      the_run->red.push_back(name);
    }
    std::printf(
        "%-16s %6.2f s  %s\n",
        outcome.status == Status::fail && !change.empty() ? "FAILED" : to_string(outcome.status),
        wall.count(), name.c_str());
    if (outcome.status == Status::unsupported) std::printf("      %s\n", outcome.note.c_str());
    if (!change.empty()) {
      std::printf("   >> %s\n", change.c_str());
      constexpr std::size_t kEnough = 4000;
      std::printf("%s", details_.substr(0, kEnough).c_str());
      if (details_.size() > kEnough) std::printf("\n      …\n");
    }
    const bool all = the_run->options.figures;
    if (all || !change.empty()) print_figures(outcome, all);
    if (the_run->options.update) the_run->table.update(name, outcome);
    std::fflush(stdout);
  }

 private:
  static void print_figures(const Outcome& outcome, bool all) {
    for (const Figure& figure : outcome.figures) {
      if (!all && figure.within()) continue;
      if (std::isinf(figure.limit)) {
        std::printf("      %12.4g               %s\n", figure.value, figure.label.c_str());
      } else {
        std::printf("    %c %12.4g of %10.4g  %s\n", figure.within() ? ' ' : '!', figure.value,
                    figure.limit, figure.label.c_str());
      }
    }
  }

  std::string details_;
  std::chrono::steady_clock::time_point start_;
};
CATCH_REGISTER_REPORTER("table", TableReporter)

class Invoker final : public Catch::ITestInvoker {
 public:
  explicit Invoker(std::function<void()> run) : run_(std::move(run)) {}
  void invoke() const override { run_(); }

 private:
  std::function<void()> run_;
};

std::set<std::string> register_generated() {
  for (const GeneratedTest& test : generated_tests()) {
    Catch::getMutableRegistryHub().registerTest(
        Catch::makeTestCase(new Invoker(test.run), std::string(),
                            Catch::NameAndTags(test.name, test.tags), CATCH_INTERNAL_LINEINFO));
  }
  std::set<std::string> names;
  for (const Catch::TestCase& test : Catch::getRegistryHub().getTestCaseRegistry().getAllTests()) {
    names.insert(test.getTestCaseInfo().name);
  }
  return names;
}

// Entries of tests that no longer exist would never be checked again.
int stale_entries(Run& run, const std::set<std::string>& names) {
  int stale = 0;
  for (auto entry = run.table.entries().begin(); entry != run.table.entries().end();) {
    if (names.count(entry->first)) {
      ++entry;
    } else if (run.options.update) {
      entry = run.table.entries().erase(entry);
    } else {
      std::printf("   >> the table has '%s', which is not a test\n", entry->first.c_str());
      ++stale;
      ++entry;
    }
  }
  return stale;
}

std::string value_of(const std::string& option) { return option.substr(option.find('=') + 1); }

// The backends named on the command line, the fault built in.
bool load_backends(const Options& options) {
  static cogrsim::PluginLoader loader(options.plugin_paths);  // keeps the libraries until the end
  std::shared_ptr<const cogrsim::Backend> loaded[2];
  const std::string names[2] = {options.backend, options.against};
  for (int i = 0; i < 2; ++i) {
    if (names[i].empty()) continue;
    auto backend = loader.backend(names[i]);
    if (!backend) {
      std::fprintf(stderr, "%s\n", backend.error().text().c_str());
      return false;
    }
    loaded[i] = *backend;
  }
  if (!options.option.empty()) {
    auto changed = with_option(loaded[0], options.option);
    if (!changed) {
      std::fprintf(stderr, "--option: %s\n", changed.error().text().c_str());
      return false;
    }
    loaded[0] = *changed;
  }
  if (!options.mutate.empty()) {
    const auto mutation = parse_mutation(options.mutate);
    if (!mutation) {
      std::fprintf(stderr, "%s\n", mutation.error().text().c_str());
      return false;
    }
    loaded[0] = mutated(loaded[0], *mutation);
  }
  for (const auto& backend : loaded) {
    if (!backend) continue;
    const auto provenance = cogrsim::provenance_of(*backend, cogrsim::SceneModel());
    if (!provenance) {
      std::fprintf(stderr, "backend '%s' does not say who computes its results: %s\n",
                   backend->name(), provenance.error().text().c_str());
      return false;
    }
  }
  set_backends(loaded[0], loaded[1]);
  return true;
}

// The table as it is laid out beside the program, in a build tree and installed.
std::string usual_table(const Options& options) {
  const std::filesystem::path program = std::filesystem::canonical("/proc/self/exe");
  return (program.parent_path().parent_path() / "share/cogrsim/expectations" /
          (options.backend + (options.against.empty() ? "" : "-" + options.against) +
           (options.option.empty() ? "" : "-" + value_of(options.option)) + ".json"))
      .string();
}

int report(Run& run, const std::set<std::string>& names) {
  const Options& options = run.options;
  const int stale = stale_entries(run, names);
  if (run.tests == 0) {
    std::printf("no test matches\n");
    return 2;
  }
  if (options.update) {
    std::string title = options.backend;
    if (!options.option.empty()) title += " with " + options.option;
    if (!options.against.empty()) title += " against " + options.against;
    run.table.save(options.expectations, title);
    std::printf("%d tests, table written: %s\n", run.tests, options.expectations.c_str());
    return 0;
  }
  if (!options.mutate.empty()) {
    std::printf("%s: %zu of %d tests turned red\n", options.mutate.c_str(), run.red.size(),
                run.tests);
    for (const std::string& name : run.red) std::printf("  %s\n", name.c_str());
    return run.red.empty() ? 1 : 0;
  }
  std::printf("%d tests, %d not as in %s\n", run.tests, run.changes + stale,
              options.expectations.c_str());
  return run.changes + stale == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Catch::Session session;
  Run run;
  the_run = &run;
  Options& options = run.options;
  std::string mutations = "build a fault in and expect a test to turn red:";
  for (const std::string& line : mutation_help()) mutations += "\n  " + line;
  using Catch::clara::Opt;
  session.cli(
      session.cli() | Opt(options.backend, "name")["--backend"]("the backend under test") |
      Opt(options.against, "name")["--against"]("a second one to compare it with") |
      Opt(options.expectations, "file")["--expectations"]("table to compare with") |
      Opt(options.plugin_paths, "dir")["--plugin-path"]("folder to look for the backend in first") |
      Opt(options.figures)["--figures"]("show every figure measured") |
      Opt(options.update)["--update"]("rewrite the table of the tests that run") |
      Opt(options.option, "name=value")["--option"]("set an option of its world everywhere") |
      Opt(options.mutate, "fault[=amount]")["--mutate"](mutations));
  session.configData().reporterName = "table";
  if (session.applyCommandLine(argc, argv) != 0) return 2;
  const Catch::ConfigData& config = session.configData();
  if (config.showHelp) return 0;
  const std::set<std::string> names = register_generated();
  if (config.listTests || config.listTags || config.listTestNamesOnly || config.listReporters) {
    session.run();
    return 0;
  }
  if (options.backend.empty()) {
    std::fprintf(stderr, "name the backend under test: --backend NAME\n");
    return 2;
  }
  if (options.expectations.empty()) {
    options.expectations = usual_table(options);
  } else if (!options.update && !std::ifstream(options.expectations)) {
    std::fprintf(stderr, "cannot read the table '%s'; with --update it is written\n",
                 options.expectations.c_str());
    return 2;
  }
  if (!load_backends(options)) return 2;
  try {
    run.table = ExpectationTable::load(options.expectations);
    session.run();
    return report(run, names);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
