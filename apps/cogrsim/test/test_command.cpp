#include "test/test_command.h"

#include <unistd.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cogrsim/dsl/edit.h"
#include "cogrsim/dsl/study.h"
#include "cogrsim/physics/backend_choice.h"
#include "common/arguments.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "test/test_case.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;
using Problem = cogrsim::Error;

constexpr std::uint64_t kMostSeeds = 100000;

// Every scene below the folders, sorted; a file stands for itself.
Result<std::vector<std::string>> scene_files(const std::vector<std::string>& arguments) {
  const std::string ending = ".scene.xml";
  std::vector<std::string> files;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!fs::is_directory(argument, error)) {
      files.push_back(argument);
      continue;
    }
    std::vector<std::string> found;
    for (fs::recursive_directory_iterator it(argument, error), end; !error && it != end;
         it.increment(error)) {
      const std::string path = it->path().string();
      if (path.size() > ending.size() &&
          path.compare(path.size() - ending.size(), ending.size(), ending) == 0)
        found.push_back(path);
    }
    if (error) return fail(error.message(), argument);
    if (found.empty()) return fail("there is no *.scene.xml below this folder", argument);
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

// The backends that both the test and the user select; an empty list selects all.
std::vector<std::string> backends_of(const TestModel& test, const TestCommandOptions& options,
                                     LoadedScene& scene) {
  if (test.backends.empty())
    return options.backends.empty() ? library_backends(scene.loader)
                                    : expand_all(options.backends, options.without, scene);
  const auto is_asked = [&](const std::string& name) {
    return std::count(options.backends.begin(), options.backends.end(), name) > 0;
  };
  std::vector<std::string> both;
  for (const std::string& name : test.backends)
    if (options.backends.empty() || is_asked(name) || is_asked("all")) both.push_back(name);
  return both;
}

bool only_lacks_plugins(const std::vector<Diagnostic>& found) {
  return std::all_of(found.begin(), found.end(), [](const Diagnostic& d) {
    return d.severity != Severity::error || d.code == "CG0901";
  });
}

// Tests come from the scene's own file: imports leave theirs behind.
bool asks_for_tests(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const auto elements = dsl::outline_text(text, file);
  return std::any_of(elements.begin(), elements.end(),
                     [](const dsl::OutlineElement& e) { return e.tag == "test"; });
}

// Adds the cases of a scene; false: it does not compile, which is a case that failed.
void plan(const std::string& file, const TestCommandOptions& options,
          std::vector<TestCase>& cases) {
  SceneOptions asked;
  asked.scene = file;
  asked.set = options.set;
  asked.plugin_paths = options.plugin_paths;
  LoadedScene scene = load_scene(asked);
  if (!scene.model) {
    // A scene without a test, whose plugins are not there, is no failure.
    if (only_lacks_plugins(scene.diagnostics) && !asks_for_tests(file)) {
      print_warning(fmt::format("{}: the scene has no tests, and its plugins are not here", file));
      return;
    }
    TestCase broken;
    broken.scene = file;
    broken.test = "compiles";
    broken.result = no_result(diagnostics_text(scene.diagnostics, false));
    cases.push_back(std::move(broken));
    return;
  }
  if (scene.model->tests.empty()) print_warning(fmt::format("{}: the scene has no tests", file));
  for (std::size_t i = 0; i < scene.model->tests.size(); ++i) {
    const TestModel& test = scene.model->tests[i];
    if (test.name.find(options.filter) == std::string::npos) continue;
    const std::vector<std::string> backends = backends_of(test, options, scene);
    if (backends.empty())
      print_warning(
          fmt::format("{}: test '{}' is for other backends than those asked for", file, test.name));
    const auto is_agree = [](const ExpectationModel& e) {
      return e.kind == ExpectationModel::Kind::agree;
    };
    const auto agrees = std::count_if(test.expectations.begin(), test.expectations.end(), is_agree);
    const bool others = agrees < static_cast<std::ptrdiff_t>(test.expectations.size());
    if (agrees > 0 && backends.size() < 2)
      print_warning(
          fmt::format("{}: test '{}' compares backends, and there is one", file, test.name));
    std::vector<std::optional<std::uint64_t>> seeds;
    for (const std::uint64_t seed : options.seeds.empty() ? test.seeds : options.seeds)
      seeds.emplace_back(seed);
    if (seeds.empty()) seeds.emplace_back();
    const auto add = [&](const std::vector<std::string>& on) {
      for (const auto& seed : seeds) {
        TestCase one;
        one.scene = file;
        one.test = test.name;
        one.index = i;
        one.backends = on;
        one.seed = seed;
        one.seed_used = seed.value_or(scene.model->physics.seed);
        cases.push_back(std::move(one));
      }
    };
    if (others)
      for (const std::string& backend : backends) add({backend});
    if (agrees > 0 && backends.size() > 1) add(backends);
  }
}

void show(const TestCase& one, const TestCommandOptions& options, const Style& style) {
  const bool good = one.passed();
  std::string text = fmt::format("{}{}{}  {}: {}  {}\n", good ? style.green : style.red,
                                 good ? "ok  " : "FAIL", style.off, one_line(one.scene),
                                 one_line(one.title()), elapsed_text(one.wall_time));
  text += printable(left_out_text(one) + errors_text(one) + failure_text(one, options));
  static_cast<void>(good ? print_report(text) : print_output(text));
}

/// Runs the cases that compiled; each is shown when all before it are over.
Result<> run_and_show(std::vector<TestCase>& cases, const TestCommandOptions& options) {
  // Scenes that do not compile need no run.
  std::vector<TestCase> open;
  for (const TestCase& one : cases)
    if (one.result.is_null()) open.push_back(one);
  const bool text = options.json != "-";
  const Style style = style_of(fileno(standard_output()));
  StatusLine line;
  std::size_t at = 0;  // in `cases`
  const auto broken = [&] {
    for (; at < cases.size() && !cases[at].result.is_null(); ++at)
      if (text) show(cases[at], options, style);
  };
  broken();
  const auto ran = run_cases(
      open, options,
      [&](const TestCase& one) {
        line.clear();
        cases[at++] = one;
        if (text) show(one, options, style);
        broken();
      },
      [&](std::size_t ended, std::size_t failed) {
        if (!line.due()) return;
        const double part =
            open.empty() ? 1.0 : static_cast<double>(ended) / static_cast<double>(open.size());
        line.show(fmt::format("{} {} of {} cases{}", bar_text(part, 30), ended, open.size(),
                              failed > 0 ? fmt::format(", {} failed", failed) : ""));
      });
  line.clear();
  if (ran) return {};
  return tl::unexpected(ran.error());
}

}  // namespace

int test_command(const TestCommandOptions& options) {
  const auto writable =
      check_writable({{options.junit, OutputKind::xml}, {options.json, OutputKind::json}});
  if (!writable) return refuse(writable.error());
  const auto files = scene_files(options.scenes);
  if (!files) {
    return refuse(files.error());
  }
  catch_interrupts();
  std::vector<TestCase> cases;
  for (const std::string& file : *files) plan(file, options, cases);
  if (cases.empty()) {
    print_error(options.filter.empty()
                    ? "there are no tests\nhelp: write <test> into a scene, see "
                      "docs/guide/scene-tests.md"
                    : fmt::format("no test has '{}' in its name", options.filter));
    return kFailed;
  }
  std::error_code ignored;
  if (!options.out.empty()) fs::create_directories(options.out, ignored);
  if (!options.out.empty() &&
      (!fs::is_directory(options.out, ignored) || access(options.out.c_str(), W_OK) != 0)) {
    print_error(Error("recordings of failed cases cannot be kept in '" + options.out + "'", "",
                      "name another folder with --output")
                    .text());
    return kFailed;
  }

  const auto ran = run_and_show(cases, options);
  if (!options.out.empty() && fs::is_empty(options.out, ignored)) fs::remove(options.out, ignored);
  if (!ran) {
    print_error(ran.error().text());
    if (options.junit.empty()) return kFailed;
    for (TestCase& one : cases) {
      if (one.result.is_null()) one.result = no_result("not run: " + ran.error().text());
    }
    if (const auto written = write_output(options.junit, OutputKind::xml, junit_text(cases));
        !written) {
      print_error(written.error().text());
    }
    return kFailed;
  }
  const auto failed =
      std::count_if(cases.begin(), cases.end(), [](const TestCase& one) { return !one.passed(); });
  if (!options.junit.empty()) {
    if (const auto written = write_output(options.junit, OutputKind::xml, junit_text(cases));
        !written) {
      return refuse(written.error());
    }
  }
  const auto printed = print_found(
      options.json, [&] { return json_text(report_json(cases, options)) + "\n"; },
      [&] {
        return fmt::format("{} case{}: {} passed, {} failed\n", cases.size(),
                           cases.size() == 1 ? "" : "s",
                           cases.size() - static_cast<std::size_t>(failed), failed);
      });
  if (!printed) return refuse(printed.error());
  return failed > 0 ? kFailed : kGood;
}

void add_test(CLI::App& app, int& status) {
  struct Arguments {
    std::vector<std::string> scenes, backends, set, plugin_paths, without;
    std::string seeds, filter, junit, json, format = "text", output, timeout;
    int jobs = 0;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App& command = *app.add_subcommand("test", "Run the tests of scenes on every backend");
  command.add_option("scenes", arguments->scenes, "Scenes, or folders of them")
      ->required()
      ->type_name("SCENE|FOLDER...");
  add_list(command, "--backends", arguments->backends,
           "Physics engines; default: the test's, else those in libraries; 'all': also those in "
           "processes of "
           "their own, but for what cannot run the scene",
           "A,B");
  command.add_option("--seeds", arguments->seeds, "Seeds; default: the test's, else the scene's")
      ->type_name("1..5|1,3");
  command
      .add_option("-j,--jobs", arguments->jobs, "Cases run at a time; default: one per processor")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command.add_option("--filter", arguments->filter, "Run only tests with this text in their name")
      ->type_name("NAME");
  command.add_option("--junit", arguments->junit, "Write the results as JUnit XML")
      ->type_name("FILE");
  add_json(command, arguments->json);
  command.add_option("--format", arguments->format, "Format of the output; json is --json -")
      ->check(CLI::IsMember({"text", "json"}))
      ->type_name("text|json");
  command
      .add_option("-o,--output,--out", arguments->output,
                  "Folder for recordings of failed cases; default: none are kept")
      ->type_name("DIR");
  command
      .add_option("--timeout", arguments->timeout,
                  "Longest wall-clock time of a case; default: no limit")
      ->type_name("T");
  add_list(command, "--set", arguments->set, "Value of a <param> of the scenes; may be repeated",
           "NAME=VALUE");
  add_without(command, arguments->without);
  add_list(command, "--plugin-path", arguments->plugin_paths,
           "Folder in which plugins and backends are looked for first; may be repeated", "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim test examples\n"
      "  cogrsim test robot.scene.xml --backends bullet,cogrsim --seeds 1..5 --junit results.xml\n"
      "Exit status 0 all passed, 1 something failed, 2 wrong usage.");
  command.callback([&status, arguments] {
    TestCommandOptions options;
    options.scenes = arguments->scenes;
    for (const std::string& list : arguments->backends)
      for (const std::string& name : split_backend_choices(list)) {
        const auto& there = options.backends;
        if (std::find(there.begin(), there.end(), name) != there.end())
          throw UsageError("--backends", Problem("'" + name + "' is given twice"));
        options.backends.push_back(name);
      }
    if (!arguments->seeds.empty()) {
      const auto seeds = dsl::parse_seeds(arguments->seeds);
      if (!seeds) throw UsageError("--seeds", seeds.error());
      if (seeds->size() > kMostSeeds)
        throw UsageError("--seeds", Problem(fmt::format("more than {} seeds", kMostSeeds)));
      options.seeds = *seeds;
    }
    if (!arguments->timeout.empty()) {
      options.timeout = time_from("--timeout", arguments->timeout);
      if (options.timeout <= 0.0)
        throw UsageError("--timeout", Problem("it must be longer than 0 s"));
    }
    options.set = settings_from(arguments->set);
    options.plugin_paths = arguments->plugin_paths;
    options.without = without_from(arguments->without);
    options.filter = arguments->filter;
    options.junit = arguments->junit;
    options.json = json_from(arguments->json, arguments->format);
    options.out = arguments->output;
    options.jobs = arguments->jobs;
    status = test_command(options);
  });
  CLI::App& one = *app.add_subcommand("test-case", "One case of `cogrsim test`")->group("");
  one.callback([&status] { status = test_case_command(); });
}

}  // namespace cogrsim::cli
