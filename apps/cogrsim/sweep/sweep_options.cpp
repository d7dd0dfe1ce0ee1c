// The options of `cogrsim sweep`.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cogrsim/physics/backend_choice.h"
#include "common/arguments.h"
#include "common/quantities.h"
#include "common/scene_loading.h"
#include "sweep/sweep_case.h"
#include "sweep/sweep_command.h"

namespace cogrsim::cli {
namespace {

using Problem = cogrsim::Error;

struct SweepArguments {
  std::string scene, seeds, until, step, timeout, memory, shard;
  std::vector<std::string> vary, set, measures, backends, plugin_paths, without;
  SweepOptions options;
};

// NAME=SIGNAL or NAME=SIGNAL@TAKE.
dsl::Study::Measure measure_from(const std::string& argument) {
  const auto pair = parse_setting(argument);
  if (!pair || pair->second.empty()) {
    throw UsageError("--measure", Problem(fmt::format("'{}' is not name=signal", argument), "",
                                          "write --measure reach=robot.x@max"));
  }
  dsl::Study::Measure measure;
  measure.name = pair->first;
  measure.signal = pair->second;
  if (const auto at = pair->second.rfind('@'); at != std::string::npos) {
    const std::string take = pair->second.substr(at + 1);
    const auto known = dsl::parse_take(take);
    if (!known) {
      throw UsageError("--measure",
                       Problem(fmt::format("'{}' is not a way to take a measure", take), "",
                               "there are last, min, max, mean, integral and first"));
    }
    measure.take = *known;
    measure.signal = pair->second.substr(0, at);
  }
  return measure;
}

// "3/16".
Shard shard_from(const std::string& argument) {
  const std::size_t slash = argument.find('/');
  const auto whole = [](const std::string& text) -> std::size_t {
    const bool digits = !text.empty() && text.size() < 8 &&
                        text.find_first_not_of("0123456789") == std::string::npos;
    return digits ? std::stoul(text) : 0;
  };
  Shard shard;
  if (slash != std::string::npos) {
    shard.number = whole(argument.substr(0, slash));
    shard.of = whole(argument.substr(slash + 1));
  }
  if (shard.number < 1 || shard.of < shard.number || shard.of > kMostRuns)
    throw UsageError("--shard", Problem(fmt::format("'{}' is not a shard", argument), "",
                                        "write 3/16 for the third of 16, from 1/16 to 16/16"));
  return shard;
}

// Nothing is run, so that nothing can be asked of runs.
SweepOptions merge_from(const CLI::App& command, const SweepArguments& arguments) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->check_name("--merge") || option->check_name("--output") ||
        option->check_name("--overwrite"))
      continue;
    throw UsageError("--merge", Problem(fmt::format("'{}' has no meaning here, nothing is run",
                                                    option->get_name()),
                                        "", "give the shards and -o alone"));
  }
  if (arguments.options.output.empty())
    throw UsageError("-o", Problem("no folder for the merged table is given", "",
                                   "give a new folder: -o study"));
  return arguments.options;
}

// "500MB", "2 GB".
std::uint64_t bytes_from(const std::string& argument) {
  for (const auto& [ending, factor] : {std::pair<const char*, double>{"GB", 1e9}, {"MB", 1e6}}) {
    const std::string end = ending;
    if (argument.size() <= end.size()) continue;
    if (argument.compare(argument.size() - 2, 2, end) != 0) continue;
    std::string number = argument.substr(0, argument.size() - 2);
    while (!number.empty() && number.back() == ' ') number.pop_back();
    const auto value = parse_number(number);
    if (value && *value * factor >= 1e6 && *value * factor <= 1e15) {
      return static_cast<std::uint64_t>(*value * factor);
    }
  }
  throw UsageError("--memory", Problem(fmt::format("'{}' is not an amount of memory", argument), "",
                                       "write it like 500MB or 2GB"));
}

// A study file has all options of the command line except --jobs and the like.
// False: it has errors, and they were printed.
bool take_study(const SweepArguments& arguments, SweepOptions& options) {
  const bool more = !arguments.vary.empty() || !arguments.set.empty() ||
                    !arguments.measures.empty() || !arguments.seeds.empty() ||
                    !arguments.backends.empty() || !arguments.until.empty();
  if (more) {
    throw UsageError(
        "sweep",
        Problem(fmt::format("'{}' is a study, which says these things itself", arguments.scene), "",
                "leave out --vary, --set, --measure, --seeds, "
                "--backends and --until"));
  }
  dsl::StudyResult read = dsl::read_study(arguments.scene);
  print_diagnostics(read.diagnostics);
  if (!read.study) return false;
  options.scene.scene = read.study->scene;
  for (const auto& setting : read.study->settings) {
    options.scene.set[setting.param] = setting.value;
  }
  options.scene.duration = read.study->until;
  options.variations = std::move(read.study->variations);
  options.seeds = std::move(read.study->seeds);
  options.backends = std::move(read.study->backends);
  options.measures = std::move(read.study->measures);
  return true;
}

void take_arguments(const SweepArguments& arguments, SweepOptions& options) {
  options.scene.scene = arguments.scene;
  options.scene.set = settings_from(arguments.set);
  for (const std::string& argument : arguments.vary) {
    dsl::Study::Variation variation = variation_from(argument);
    for (const auto& other : options.variations) {
      if (other.param == variation.param) {
        throw UsageError(
            "--vary", Problem(fmt::format("'{}' is varied twice", variation.param), "",
                              "put the values together: " + variation.param + "=3cm,5cm..7cm:3"));
      }
    }
    options.variations.push_back(std::move(variation));
  }
  for (const std::string& argument : arguments.measures) {
    dsl::Study::Measure measure = measure_from(argument);
    for (const auto& other : options.measures) {
      if (other.name == measure.name) {
        throw UsageError("--measure", Problem(fmt::format("'{}' is given twice", measure.name)));
      }
    }
    options.measures.push_back(std::move(measure));
  }
  if (!arguments.seeds.empty()) {
    auto seeds = dsl::parse_seeds(arguments.seeds);
    if (!seeds) throw UsageError("--seeds", seeds.error());
    options.seeds = std::move(*seeds);
  }
  options.backends = backends_from(arguments.backends);
  if (!arguments.until.empty()) options.scene.duration = seconds_from("--until", arguments.until);
}

std::optional<SweepOptions> options_from(const SweepArguments& arguments) {
  SweepOptions options = arguments.options;
  options.scene.plugin_paths = arguments.plugin_paths;
  options.scene.without = without_from(arguments.without);
  if (dsl::is_study(arguments.scene)) {
    if (!take_study(arguments, options)) return std::nullopt;
  } else {
    take_arguments(arguments, options);
  }
  if (!arguments.step.empty()) options.step = step_from(arguments.step);
  if (!arguments.timeout.empty()) options.timeout = seconds_from("--timeout", arguments.timeout);
  if (!arguments.shard.empty()) options.shard = shard_from(arguments.shard);
  if (!arguments.memory.empty()) options.memory_limit = bytes_from(arguments.memory);
  if (options.output.empty() && !options.dry_run) {
    throw UsageError(
        "-o", Problem("no folder for the results is given", "", "give a folder: -o results"));
  }
  return options;
}

}  // namespace

dsl::Study::Variation variation_from(const std::string& argument) {
  const auto pair = parse_setting(argument);
  if (!pair)
    throw UsageError("--vary", Problem(fmt::format("'{}' is not name=values", argument), "",
                                       "write --vary r=3cm..5cm:5 or --vary r=3cm,4cm"));
  auto values = dsl::parse_study_values(pair->second);
  if (!values) throw UsageError("--vary " + pair->first, values.error());
  return {pair->first, std::move(*values)};
}

double seconds_from(const char* option, const std::string& argument) {
  return time_from(option, argument, kAboveZero, kLongestDuration,
                   "it must be more than 0 s and at most 1e9 s");
}

std::vector<std::string> backends_from(const std::vector<std::string>& lists) {
  std::vector<std::string> out;
  for (const std::string& list : lists) {
    for (const std::string& name : split_backend_choices(list)) {
      if (std::count(out.begin(), out.end(), name) > 0) {
        throw UsageError("--backends", Problem(fmt::format("'{}' is given twice", name)));
      }
      out.push_back(name);
    }
  }
  return out;
}

void add_processes(CLI::App& command, SweepOptions& options, std::string& timeout) {
  command
      .add_option("-j,--jobs", options.jobs,
                  "Runs at a time; default: one per core, under mpirun one per process")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  command.add_option("--timeout", timeout, "Wall-clock time after which a run is given up")
      ->type_name("T");
  command.add_flag("--retry", options.retry,
                   "Repeat runs that crashed, failed, or ran out of time or memory");
  command.add_flag("--dry-run", options.dry_run, "List the runs and do nothing");
}

void add_sweep(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("sweep", "Run a scene many times and gather a table");
  const auto arguments = std::make_shared<SweepArguments>();
  command
      .add_option("scene", arguments->scene,
                  "Scene, or a study file, which has all of the options below")
      ->type_name("SCENE|STUDY.xml");
  add_list(command, "--vary", arguments->vary,
           "Values of a <param>: a list, a range with a count (3cm..5cm:5, 1..100:3:log), or both; "
           "several of them make a grid",
           "NAME=VALUES");
  command
      .add_option("--seeds", arguments->seeds,
                  "Seeds, such as 1..100 or 1,5,9; default: the scene's")
      ->type_name("LIST");
  add_list(command, "-b,--backends", arguments->backends,
           "Physics engines, with commas; default: the scene's; 'all': those that run the scene",
           "A,B");
  add_list(command, "--measure", arguments->measures,
           "A number for the table: of a signal the last, min, max, mean or integral, of a "
           "condition the first time; beside the scene's <measure>s",
           "NAME=SIGNAL[@TAKE]");
  add_list(command, "--set", arguments->set,
           "A <param> that is the same in all runs; may be repeated", "NAME=VALUE");
  add_without(command, arguments->without);
  command
      .add_option("--until", arguments->until, "End of each run; default: the scene's, else 10 s")
      ->type_name("T");
  command.add_option("--step", arguments->step, "Step length; default: the scene's")
      ->type_name("DT");
  add_processes(command, arguments->options, arguments->timeout);
  command.add_option("--memory", arguments->memory, "Memory beyond which a run is given up")
      ->type_name("SIZE");
  command
      .add_option(
          "--shard", arguments->shard,
          "Only the runs of one shard of a number of them, 1/16 to 16/16, each with a folder "
          "of its own; --merge makes one table of all")
      ->type_name("N/OF");
  command
      .add_option("--merge", arguments->options.merged,
                  "Folders of all shards of a study, instead of a scene: -o gets the table of the "
                  "whole, as if one machine had run it")
      ->type_name("DIR...")
      ->expected(1, -1);
  command
      .add_option("-o,--output", arguments->options.output,
                  "Folder of results.sqlite and results.csv; a study that is there is continued")
      ->type_name("DIR");
  command
      .add_option("--plugin-path", arguments->plugin_paths,
                  "Folder in which plugins and backends are looked for first; may be repeated")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.footer(
      "Examples:\n"
      "  cogrsim sweep robot.scene.xml --vary r=3cm..5cm:5 --seeds 1..20 -o study\n"
      "  cogrsim sweep robot.scene.xml --vary r=3cm,4cm --vary load=1kg,2kg --backends "
      "bullet,cogrsim \\\n      --measure far=robot.x@max --measure \"crash=contacts(robot, wall) "
      "gt 0@first\" -o study\n"
      "  cogrsim sweep study.xml -o study --jobs 4      a study file, see docs/guide/sweeps.md\n"
      "  mpirun -n 8 cogrsim sweep study.xml -o study   spread over processes and hosts\n"
      "  cogrsim sweep study.xml --shard 3/16 -o part3   a part of it, as a job of its own\n"
      "  cogrsim sweep --merge part* -o study           one table of all parts\n"
      "  cogrsim plot study --kind box --x r --y far --by backend -o far.svg\n"
      "A sweep that was ended or killed resumes when the same command is given again; a run that\n"
      "crashes is a row with its cause.");
  command.callback([arguments, &command, &status] {
    if (!arguments->options.merged.empty()) {
      status = sweep_command(merge_from(command, *arguments));
      return;
    }
    if (arguments->scene.empty())
      throw UsageError("scene", Problem("no scene is given", "", "or give shards to --merge"));
    auto options = options_from(*arguments);
    status = options ? sweep_command(*options) : kFailed;
  });

  CLI::App& one = *app.add_subcommand("sweep-case", "One run of a sweep");
  one.group("");  // not for people
  one.callback([&status] { status = sweep_case_command(); });
}

}  // namespace cogrsim::cli
