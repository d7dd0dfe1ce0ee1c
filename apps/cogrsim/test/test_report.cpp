// The output of `cogrsim test`, for people and for programs.
#include <map>

#include <fmt/format.h>

#include "common/terminal.h"
#include "compare/zoom_chart.h"
#include "test/test_command.h"

namespace cogrsim::cli {
namespace {

// XML 1.0 takes no control characters but tab and newline, and attributes no newline as it is.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : html_escaped(text)) {
    if (c == '\n') {
      out += "&#10;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string again(const TestCase& one, const TestCommandOptions& options) {
  if (one.backends.empty()) return "cogrsim check " + shell_quoted(one.scene);
  std::string backends;
  for (const std::string& backend : one.backends)
    backends += (backends.empty() ? "" : ",") + backend;
  std::string out =
      fmt::format("cogrsim test {} --filter {} --backends {} --seeds {}", shell_quoted(one.scene),
                  shell_quoted(one.test), shell_quoted(backends), one.seed_used);
  for (const auto& [name, value] : options.set) out += " --set " + shell_quoted(name + "=" + value);
  if (!options.without.empty())
    out += " --without " + shell_quoted(fmt::format("{}", fmt::join(options.without, ",")));
  if (options.timeout > 0.0) out += fmt::format(" --timeout {}s", options.timeout);
  for (const std::string& path : options.plugin_paths) {
    out += " --plugin-path " + shell_quoted(path);
  }
  return out;
}

std::string indented(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    out += "  " + text.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return out;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string headline(const TestCase& one) {
  for (const Json& verdict : one.result["verdicts"])
    if (!verdict["passed"].get<bool>())
      return first_line(verdict["text"].get<std::string>()) + ": " +
             verdict["message"].get<std::string>();
  return first_line(one.result["message"].get<std::string>());
}

}  // namespace

std::string TestCase::title() const {
  if (backends.empty()) return test;
  std::string where;
  for (const std::string& backend : backends) where += (where.empty() ? "" : "+") + backend;
  return fmt::format("{} [{}, seed {}]", test, where, seed_used);
}

std::string left_out_text(const TestCase& one) {
  std::string out;
  if (one.result.contains("left_out"))
    for (const auto& [backend, text] : one.result["left_out"].items())
      out += indented(fmt::format("{} without {}", backend, text.get<std::string>()));
  return out;
}

std::string errors_text(const TestCase& one) {
  std::string out;
  for (const Json& error : one.result["errors"])
    out += indented("error: " + error.get<std::string>());
  return out;
}

std::string failure_text(const TestCase& one, const TestCommandOptions& options) {
  if (one.passed()) return {};
  std::string out;
  if (!one.result["message"].get<std::string>().empty())
    out += indented(one.result["message"].get<std::string>());
  for (const Json& verdict : one.result["verdicts"])
    if (!verdict["passed"].get<bool>()) out += indented(verdict["text"].get<std::string>());
  for (const Json& file : one.result["recordings"])
    out += "  recording: " + file.get<std::string>() + "\n";
  if (options.out.empty() && !one.backends.empty())
    out += "  no recording: --out DIR keeps one of each failed case\n";
  if (one.result.contains("unrecorded"))
    out += indented("no recording: " + one.result["unrecorded"].get<std::string>());
  return out + "  again: " + one_line(again(one, options)) + "\n";
}

std::string junit_text(const std::vector<TestCase>& cases) {
  struct Suite {
    std::string name, body;
    int tests = 0, failures = 0, errors = 0;
    double time = 0.0;
  };
  std::vector<Suite> suites;
  Suite all;
  for (const TestCase& one : cases) {
    if (suites.empty() || suites.back().name != one.scene) {
      suites.emplace_back();
      suites.back().name = one.scene;
    }
    Suite& suite = suites.back();
    std::string location;
    for (const Json& verdict : one.result["verdicts"])
      if (location.empty() && !verdict["file"].is_null())
        location =
            fmt::format(" file=\"{}\" line=\"{}\"", escaped(verdict["file"].get<std::string>()),
                        verdict["line"].get<int>());
    suite.body += fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"{}",
                              escaped(one.scene), escaped(one.title()), one.wall_time, location);
    ++suite.tests;
    suite.time += one.wall_time;
    const std::string errors = errors_text(one);
    const std::string left_out = left_out_text(one);
    const std::string output =
        (left_out.empty() ? "" : "      <system-out>" + escaped(left_out) + "</system-out>\n") +
        (errors.empty() ? "" : "      <system-err>" + escaped(errors) + "</system-err>\n");
    if (one.passed()) {
      suite.body += output.empty() ? "/>\n" : ">\n" + output + "    </testcase>\n";
      continue;
    }
    const bool error = one.result["status"] == "error";
    ++(error ? suite.errors : suite.failures);
    const char* tag = error ? "error" : "failure";
    suite.body +=
        fmt::format(">\n      <{} message=\"{}\" type=\"{}\">{}</{}>\n{}    </testcase>\n", tag,
                    escaped(headline(one)), error ? "error" : "expectation",
                    escaped(failure_text(one, {})), tag, output);
  }
  std::string body;
  for (const Suite& suite : suites) {
    body += fmt::format(
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"0\" "
        "time=\"{:.3f}\">\n{}  </testsuite>\n",
        escaped(suite.name), suite.tests, suite.failures, suite.errors, suite.time, suite.body);
    all.tests += suite.tests;
    all.failures += suite.failures;
    all.errors += suite.errors;
    all.time += suite.time;
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuites name=\"cogrsim test\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "time=\"{:.3f}\">\n{}</testsuites>\n",
      all.tests, all.failures, all.errors, all.time, body);
}

Json report_json(const std::vector<TestCase>& cases, const TestCommandOptions& options) {
  Json out;
  int failed = 0;
  out["cases"] = Json::array();
  for (const TestCase& one : cases) {
    failed += one.passed() ? 0 : 1;
    Json entry = {{"scene", one.scene},
                  {"test", one.test},
                  {"backends", one.backends},
                  {"seed", one.seed_used},
                  {"wall_time", one.wall_time}};
    for (const auto& [key, value] : one.result.items()) entry[key] = value;
    for (Json& verdict : entry["verdicts"]) verdict.erase("text");
    if (!one.passed()) entry["again"] = again(one, options);
    out["cases"].push_back(std::move(entry));
  }
  out["passed"] = static_cast<int>(cases.size()) - failed;
  out["failed"] = failed;
  return out;
}

}  // namespace cogrsim::cli
