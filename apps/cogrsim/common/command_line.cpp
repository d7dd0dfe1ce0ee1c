#include "common/command_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cogrsim/core/parameter.h"
#include "cogrsim/dsl/study.h"
#include "cogrsim/physics/backend_choice.h"
#include "common/arguments.h"
#include "common/command_pages.h"
#include "common/complete.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/quantities.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "import/export_command.h"
#include "import/import_command.h"
#include "live/live_options.h"
#include "new/new_command.h"
#include "policy/policy_command.h"
#include "policy/transfer_command.h"
#include "render/picture_options.h"
#include "replay/recording_options.h"
#include "sweep/sweep_command.h"
#include "test/test_command.h"
#include "watch/watch_command.h"

namespace cogrsim::cli {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

// Arguments as they were typed; they become options once all are known.
struct Arguments {
  std::vector<std::string> global_plugin_paths, plugin_paths;  // before and after the subcommand
  std::vector<std::string> scenes;
  std::string scene, backend, duration, speed, seed, json, record, report, code, format = "text";
  std::vector<std::string> steps, set, thresholds, backends, without;
  std::vector<std::string> files, plots, x, y, z, by, save_at;
  std::string snapshot, inputs, plots_folder, kind, title, every, from, to, output = "plots",
                                                                    picture = "png";
  int rows = 10;
  std::string seeds, shake, table;
  std::string shell, command, live;
  std::vector<std::string> live_origins;
  bool chaos = false;
  bool with_live = false, reference = false, man = false, events = false, watch = false;
};

constexpr std::size_t kMostRepetitions = 10000;  // of a comparison

double speed_from(const std::string& argument) {
  if (argument == "max") return std::numeric_limits<double>::infinity();
  const std::string number = !argument.empty() && argument.back() == 'x'
                                 ? argument.substr(0, argument.size() - 1)
                                 : argument;
  const auto speed = parse_number(number);
  if (!speed || *speed <= 0.0) {
    throw UsageError("--speed",
                     Problem(fmt::format("'{}' is not a speed", argument), "",
                             "write simulated seconds per second, such as 1 or 0.25, or max"));
  }
  return *speed;
}

// Folders given behind the subcommand are more specific, and searched first.
std::vector<std::string> plugin_paths_from(const Arguments& arguments) {
  std::vector<std::string> paths = arguments.plugin_paths;
  paths.insert(paths.end(), arguments.global_plugin_paths.begin(),
               arguments.global_plugin_paths.end());
  return paths;
}

SceneOptions scene_from(const Arguments& arguments) {
  SceneOptions options;
  options.scene = arguments.scene;
  options.set = settings_from(arguments.set);
  if (!arguments.seed.empty()) options.seed = seed_from(arguments.seed);
  if (!arguments.duration.empty()) {
    options.duration = time_from("--duration", arguments.duration, kAboveZero, kLongestDuration,
                                 "a run lasts more than 0 s and at most 1e9 s");
  }
  options.plugin_paths = plugin_paths_from(arguments);
  options.without = without_from(arguments.without);
  return options;
}

// Pairs of time and file, by time.
std::vector<RunOptions::Save> saves_from(const std::vector<std::string>& arguments) {
  std::vector<RunOptions::Save> saves;
  if (arguments.size() % 2 != 0) {
    throw UsageError("--save-at", Problem("a snapshot needs a time and a file", "",
                                          "write --save-at 2s two.snap"));
  }
  for (std::size_t i = 0; i + 1 < arguments.size(); i += 2) {
    const double time = time_from("--save-at", arguments[i], 0.0, kLongestDuration);
    for (const RunOptions::Save& other : saves) {
      if (other.file == arguments[i + 1]) {
        throw UsageError("--save-at", Problem(fmt::format("'{}' is named twice", other.file), "",
                                              "each snapshot needs a file of its own"));
      }
    }
    saves.push_back({time, arguments[i + 1]});
  }
  std::stable_sort(saves.begin(), saves.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  return saves;
}

RunOptions run_from(const Arguments& arguments) {
  RunOptions options;
  if (arguments.backend == "all") {
    throw UsageError("--backend", Problem("a run has one backend", "",
                                          "all of them are for cogrsim compare --backends all"));
  }
  options.scene = scene_from(arguments);
  options.backend = arguments.backend;
  if (arguments.steps.size() > 1) {
    throw UsageError("--step",
                     Problem("a run has one step", "", "several are for cogrsim compare"));
  }
  if (!arguments.steps.empty()) options.step = step_from(arguments.steps.front());
  if (!arguments.speed.empty()) options.speed = speed_from(arguments.speed);
  options.json = arguments.json;
  options.plots = arguments.plots_folder;
  options.record = arguments.record;
  options.from = arguments.snapshot;
  options.inputs = arguments.inputs;
  options.saves = saves_from(arguments.save_at);
  options.events = arguments.events;
  if (arguments.with_live) {
    options.live = live_from(arguments.live);
    options.live->origins = arguments.live_origins;
    // What is watched has the pace of the world.
    if (arguments.speed.empty()) options.speed = 1.0;
  } else if (!arguments.live_origins.empty()) {
    throw UsageError("--live-origin", Problem("only a run with --live has clients"));
  }
  if (arguments.watch && options.json == "-") {
    throw UsageError("--watch", Problem("--json - is for one result, and here come several", "",
                                        "name a file, which has the latest: --json result.json"));
  }
  if (!arguments.inputs.empty() && (arguments.watch || !arguments.snapshot.empty())) {
    throw UsageError(arguments.watch ? "--watch" : "--from",
                     Problem(arguments.watch ? "--inputs are for one run"
                                             : "--inputs are for a run from the start",
                             "", "leave out one of them"));
  }
  if (!options.record.empty() && options.record == options.json) {
    throw UsageError("--record", Problem("--record and --json name the same file"));
  }
  return options;
}

PlotCommandOptions plot_from(const Arguments& arguments) {
  PlotCommandOptions options;
  options.files = arguments.files;
  options.plots = arguments.plots;
  options.kind = arguments.kind;
  options.x = arguments.x;
  options.y = arguments.y;
  options.z = arguments.z;
  options.by = arguments.by;
  options.title = arguments.title;
  if (!arguments.every.empty()) options.every = time_from("--every", arguments.every);
  if (!arguments.from.empty()) options.from = time_from("--from", arguments.from);
  if (!arguments.to.empty()) options.to = time_from("--to", arguments.to);
  options.output = arguments.output;
  options.format = arguments.picture;
  if (options.every && *options.every < 0.0) {
    throw UsageError("--every", Problem(fmt::format("'{}' is negative", arguments.every)));
  }
  if (options.from && options.to && *options.from > *options.to) {
    throw UsageError("--from", Problem("the time ends before it begins"));
  }
  const bool signals = !arguments.x.empty() || !arguments.y.empty() || !arguments.z.empty();
  if (!arguments.plots.empty() && (signals || !arguments.kind.empty())) {
    throw UsageError("--plot", Problem("either a plot of the scene or one made up here", "",
                                       "leave out --plot, or --kind and the signals"));
  }
  return options;
}

CompareCommandOptions compare_from(const Arguments& arguments) {
  CompareCommandOptions options;
  options.scene = scene_from(arguments);
  for (const std::string& list : arguments.backends) {
    for (const std::string& choice : split_backend_choices(list))
      options.backends.push_back(choice);
  }
  if (options.backends.size() == 1 && options.backends.front() != "all") {
    throw UsageError("--backends", Problem("a comparison needs at least two", "",
                                           "write them with commas: --backends A,B, or all"));
  }
  for (const std::string& list : arguments.steps) {
    for (const std::string& argument : split(list, ',')) {
      const double step = step_from(argument);
      for (const double other : options.steps) {
        if (std::fabs(step - other) <= 1e-9 * step) {
          throw UsageError("--step", Problem(fmt::format("'{}' is given twice", argument)));
        }
      }
      options.steps.push_back(step);
    }
  }
  for (const std::string& list : arguments.thresholds) {
    for (const std::string& argument : split(list, ',')) {
      const auto threshold = parse_length_or_angle(argument);
      if (!threshold) throw UsageError("--threshold", threshold.error());
      if (threshold->value <= 0.0) {
        throw UsageError("--threshold",
                         Problem(fmt::format("'{}' is not greater than zero", argument)));
      }
      const bool angle = threshold->dimension == Dimension::angle;
      (angle ? options.angle_threshold : options.position_threshold) = threshold->value;
    }
  }
  if (!arguments.seeds.empty()) {
    const auto seeds = dsl::parse_seeds(arguments.seeds);
    if (!seeds) throw UsageError("--seeds", seeds.error());
    if (seeds->size() > kMostRepetitions) {
      throw UsageError("--seeds", Problem(fmt::format("more than {} seeds", kMostRepetitions)));
    }
    if (!arguments.seed.empty())
      throw UsageError("--seeds", Problem("--seed is one of them already"));
    if (options.steps.size() > 1) {
      throw UsageError("--seeds", Problem("several seeds and several steps are two studies", "",
                                          "give one --step, or leave out --seeds"));
    }
    options.seeds = *seeds;
  }
  if (!arguments.shake.empty()) {
    const auto size = parse_length_or_angle(arguments.shake);
    if (!size || size->dimension == Dimension::angle || size->value <= 0.0) {
      throw UsageError("--shake", Problem(fmt::format("'{}' is not a length", arguments.shake), "",
                                          "write a length greater than zero, such as 1mm"));
    }
    options.shake = size->value;
  }
  options.chaos = arguments.chaos;
  options.rows = arguments.rows;
  options.json = arguments.json;
  options.report = arguments.report;
  options.table = arguments.table;
  const auto ending =
      options.table.substr(std::min(options.table.rfind('.'), options.table.size()));
  if (!options.table.empty() && ending != ".md" && ending != ".tex") {
    throw UsageError("--table",
                     Problem(fmt::format("'{}' ends neither in .md nor in .tex", options.table)));
  }
  if (!options.json.empty() && options.json == options.report) {
    throw UsageError("--report", Problem("--json and --report name the same file"));
  }
  return options;
}

void add_plugin_path(CLI::App& command, std::vector<std::string>& paths) {
  command
      .add_option("--plugin-path", paths,
                  "Folder in which plugins and backends are looked for first; may be repeated")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_set(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--set", arguments.set,
                  "Value of a <param> of the scene, in the scene's own notation; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_scene_options(CLI::App& command, Arguments& arguments) {
  command.add_option("scene", arguments.scene, "Scene file, NAME.scene.xml")
      ->required()
      ->type_name("SCENE");
  command
      .add_option("-d,--duration", arguments.duration,
                  "Simulated time, such as 5, \"5 s\" or 500ms; default: the scene's, else 10 s")
      ->type_name("T");
  command.add_option("--seed", arguments.seed, "Seed of all randomness; default: the scene's")
      ->type_name("N");
  add_set(command, arguments);
  add_without(command, arguments.without);
  add_plugin_path(command, arguments.plugin_paths);
}

void add_run(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App& command = *app.add_subcommand("run", "Run a scene on one backend");
  add_scene_options(command, arguments);
  command.add_option("-b,--backend", arguments.backend, "Physics engine; default: the scene's")
      ->type_name("B");
  command
      .add_option("--step", arguments.steps,
                  "Step length, such as 0.001 or \"1 ms\"; default: the scene's")
      ->type_name("DT")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--speed", arguments.speed,
                  "Simulated seconds per second, or max, the default; never changes a result")
      ->type_name("X|max");
  add_json(command, arguments.json);
  command
      .add_option("--record", arguments.record,
                  "Record the run for replay; default: what <record> in the scene says")
      ->type_name("FILE.mcap");
  command.add_option("--plots", arguments.plots_folder, "Draw the scene's plots into this folder")
      ->type_name("DIR");
  command
      .add_option("--save-at", arguments.save_at,
                  "Save the state at this time as a snapshot, from which a run can resume; "
                  "may be repeated")
      ->type_name("T FILE.snap")
      ->expected(2)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--from", arguments.snapshot,
                  "Resume from a snapshot; --backend, --set and --seed may differ from the saved "
                  "run, and what cannot be carried over is reported")
      ->type_name("FILE.snap");
  const CLI::Option* const live =
      command
          .add_option(
              "--live", arguments.live,
              "Serve the run to Foxglove and other clients of its protocol, in real time and until "
              "Ctrl-C unless --speed and --duration say otherwise; default: 127.0.0.1:8765")
          ->type_name("ADDRESS")
          ->expected(0, 1);
  command
      .add_option("--live-origin", arguments.live_origins,
                  "A further page whose viewer may connect, such as https://viewer.example; may be "
                  "repeated")
      ->type_name("URL")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--inputs", arguments.inputs,
                  "Repeat what a person did in a recorded run of the studio: motors, forces, step "
                  "length; --backend and --step are those of that run, unless they are given")
      ->type_name("RUN.mcap|FILE");
  command.add_flag("--events", arguments.events,
                   "Print every event as it occurs: time, kind, source, subject, message");
  command.add_flag(
      "--watch", arguments.watch,
      "Restart whenever the scene, a file or plugin that it uses, or one that it misses "
      "changes; Ctrl-C ends");
  command.footer(
      "Examples:\n"
      "  cogrsim run robot.scene.xml\n"
      "  cogrsim run robot.scene.xml --backend cogrsim --duration 5s --step \"0.5 ms\"\n"
      "  cogrsim run robot.scene.xml --set wheel_r=\"5 cm\" --seed 7 --json result.json\n"
      "  cogrsim run robot.scene.xml --speed 1      in real time\n"
      "  cogrsim run robot.scene.xml --json - | jq .energy\n"
      "  cogrsim run robot.scene.xml --record robot.mcap      then: cogrsim info robot.mcap\n"
      "  cogrsim run robot.scene.xml --save-at 2s two.snap      then: what if the floor were icy?\n"
      "  cogrsim run robot.scene.xml --from two.snap --set friction=0.05\n"
      "  cogrsim run robot.scene.xml --events      who entered where, which door opened, and when\n"
      "  cogrsim run robot.scene.xml --live      in Foxglove: open ws://localhost:8765\n"
      "  cogrsim run robot.scene.xml --watch --plots plots      while you work on it\n"
      "Ctrl-C ends the run and prints the result so far; exit status 0 good, 1 failed, 2 wrong "
      "usage.");
  command.callback([&, live] {
    arguments.with_live = live->count() > 0;
    const RunOptions options = run_from(arguments);
    status = arguments.watch ? watch_command(options) : run_command(options);
  });
}

void add_plot(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App& command = *app.add_subcommand("plot", "Draw figures of recorded runs and of studies");
  command
      .add_option(
          "files", arguments.files,
          "Recordings, which become series of the same figure; or one figure, NAME.json; or the "
          "folder, results.sqlite or results.csv of a study")
      ->required()
      ->type_name("RUN.mcap...|DIR");
  add_list(command, "--plot", arguments.plots,
           "A plot of the scene, by name; may be repeated; default: all", "NAME");
  command.add_option("--kind", arguments.kind, "Kind of a figure that is not in the scene")
      ->check(CLI::IsMember({"curve", "box", "surface", "histogram", "map"}))
      ->type_name("K");
  add_list(command, "--x", arguments.x, "Signal along x; a curve's is the time if left out",
           "SIGNAL");
  add_list(command, "--y", arguments.y, "Signal along y; may be repeated for several series",
           "SIGNAL");
  add_list(command, "--z", arguments.z, "Signal along z, the height of a surface", "SIGNAL");
  add_list(command, "--by", arguments.by,
           "Of a study: the column whose values become the series; --x, --y and --z are "
           "columns, too",
           "COLUMN");
  command.add_option("--title", arguments.title, "Title of the figure")->type_name("TEXT");
  command.add_option("--every", arguments.every, "Time between samples; 0: every recorded frame")
      ->type_name("DT");
  command.add_option("--from", arguments.from, "Leave out the samples before this time")
      ->type_name("T");
  command.add_option("--to", arguments.to, "Leave out the samples after this time")->type_name("T");
  command
      .add_option("-o,--output", arguments.output,
                  "NAME.png, .svg, .pdf or .json for one figure; else a folder for all")
      ->type_name("FILE|DIR")
      ->capture_default_str();
  command.add_option("--format", arguments.picture, "Format of the pictures in a folder")
      ->check(CLI::IsMember({"png", "svg", "pdf", "json"}))
      ->type_name("F")
      ->capture_default_str();
  command.footer(
      "Examples:\n"
      "  cogrsim plot run.mcap                          the scene's plots, into the folder plots\n"
      "  cogrsim plot run.mcap --plot path -o path.pdf\n"
      "  cogrsim plot run.mcap --y robot.speed -o speed.svg\n"
      "  cogrsim plot bullet.mcap cogrsim.mcap --kind map --x robot.x --y robot.y -o path.png\n"
      "  cogrsim plot run.mcap --kind surface --x robot.x --y robot.y --z robot.speed -o "
      "floor.png\n"
      "  cogrsim plot path.json -o path.svg             a figure drawn before\n"
      "  cogrsim plot study --kind box --x r --y time --by backend -o time.svg\n"
      "Beside a picture stay its script (gnuplot NAME.gp draws it again), data and NAME.json.");
  command.callback([&] { status = plot_command(plot_from(arguments)); });
}

void add_compare(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App& command =
      *app.add_subcommand("compare", "Run a scene on several backends side by side");
  add_scene_options(command, arguments);
  command
      .add_option("-b,--backends", arguments.backends,
                  "Backends, with commas; the first is the reference; default: those in libraries; "
                  "'all': also those in processes of their own, but for what cannot run the scene")
      ->type_name("A,B")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option(
          "--step", arguments.steps,
          "Step length; the comparison uses the first, several add convergence: each backend "
          "against itself at smaller steps")
      ->type_name("DT")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--threshold", arguments.thresholds,
                  "Difference from which two runs diverge: a length (metres without unit), an "
                  "angle, or both; default: 1cm,1deg")
      ->type_name("X")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--rows", arguments.rows, "Bodies and joints shown in the tables")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  add_json(command, arguments.json);
  command.add_option("--report", arguments.report, "Write a page with curves for a browser")
      ->type_name("FILE.html");
  command
      .add_option(
          "--seeds", arguments.seeds,
          "Repeat with each of these: mean, standard deviation and 95 % confidence interval "
          "of the differences; 1..20, or 1 3 7")
      ->type_name("SEEDS");
  command
      .add_option("--shake", arguments.shake,
                  "Displace the start of each repetition at random by at most this, alike on all "
                  "backends; joints by as many radians as it has metres")
      ->type_name("SIZE");
  command.add_flag(
      "--chaos", arguments.chaos,
      "Run the reference once more, its start shaken by 1 nm: when the two diverge, chaos "
      "decides and not the engine; always with --seeds and --shake");
  command
      .add_option("--table", arguments.table,
                  "Write the differences as a table for a paper, markdown or LaTeX by the ending")
      ->type_name("FILE.md|FILE.tex");
  command.footer(
      "Examples:\n"
      "  cogrsim compare robot.scene.xml --backends bullet,cogrsim\n"
      "  cogrsim compare robot.scene.xml --duration 3s --threshold 5mm,2deg\n"
      "  cogrsim compare robot.scene.xml --report robot.html --json robot.json\n"
      "  cogrsim compare robot.scene.xml --step 4ms --step 2ms --step 1ms      with convergence\n"
      "  cogrsim compare robot.scene.xml --backends \"bullet,bullet(iterations=50),cogrsim\"\n"
      "  cogrsim compare robot.scene.xml --seeds 1..20 --shake 1mm --table robot.tex\n"
      "  cogrsim compare robot.scene.xml --without lacking     each engine without what it lacks\n"
      "Differences are a finding, not a failure: exit status 0 unless a scene or a run failed.");
  command.callback([&] { status = compare_command(compare_from(arguments)); });
}

void add_check(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App& command =
      *app.add_subcommand("check", "Report what is wrong with scenes, without running them");
  command.add_option("scenes", arguments.scenes, "Scene files")->required()->type_name("SCENE...");
  command
      .add_option("-b,--backend", arguments.backend,
                  "Also report what this backend cannot do of the scene; default: the scene's own")
      ->type_name("B");
  add_json(command, arguments.json, "Write the findings as JSON");
  command
      .add_option("--format", arguments.format,
                  "Format of the findings: text, json, which is --json -, or sarif")
      ->check(CLI::IsMember({"text", "json", "sarif"}))
      ->type_name("F")
      ->capture_default_str();
  add_set(command, arguments);
  add_without(command, arguments.without);
  add_plugin_path(command, arguments.plugin_paths);
  command.footer(
      "Examples:\n"
      "  cogrsim check robot.scene.xml\n"
      "  cogrsim check scenes/*.scene.xml --backend bullet\n"
      "  cogrsim check robot.scene.xml --format sarif > findings.sarif");
  command.callback([&] {
    CheckOptions options;
    options.scenes = arguments.scenes;
    options.set = settings_from(arguments.set);
    options.backend = arguments.backend;
    options.json = json_from(arguments.json, arguments.format);
    options.sarif = arguments.format == "sarif";
    options.without = without_from(arguments.without);
    options.plugin_paths = plugin_paths_from(arguments);
    status = check_command(options);
  });
}

void add_small_ones(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App& explain = *app.add_subcommand("explain", "Explain a code such as CG0502");
  explain.add_option("code", arguments.code, "The code; without one, all are listed")
      ->type_name("CODE");
  explain.footer("Examples:\n  cogrsim explain CG0502\n  cogrsim explain");
  explain.callback([&] { status = explain_command(arguments.code); });

  CLI::App& schema = *app.add_subcommand("schema", "Print the scene language for an editor (XSD)");
  schema.add_flag("--reference", arguments.reference,
                  "Print the reference page (Markdown) instead");
  add_json(schema, arguments.json, "Write it as JSON instead, with the plugins' parameters");
  add_plugin_path(schema, arguments.plugin_paths);
  schema.footer(
      "Examples:\n"
      "  cogrsim schema > scene.xsd      gives completion in an editor\n"
      "  cogrsim schema --reference > scene-reference.md\n"
      "  cogrsim schema --json | jq -r '.elements[].name'");
  schema.callback([&] {
    status = schema_command(arguments.reference, arguments.json, plugin_paths_from(arguments));
  });

  CLI::App& plugins =
      *app.add_subcommand("plugins", "List backends, controllers, supervisors, sensors");
  add_json(plugins, arguments.json);
  add_plugin_path(plugins, arguments.plugin_paths);
  plugins.footer(
      "Examples:\n"
      "  cogrsim plugins\n"
      "  cogrsim plugins --plugin-path ./build/cogrsim_plugins\n"
      "  cogrsim plugins --json | jq -r '.plugins[].name'");
  plugins.callback([&] {
    PluginsOptions options;
    options.json = arguments.json;
    options.plugin_paths = plugin_paths_from(arguments);
    status = plugins_command(options);
  });

  CLI::App& doctor = *app.add_subcommand(
      "doctor", "Say what is missing on this machine, or does not work, and how to get it");
  add_json(doctor, arguments.json);
  add_plugin_path(doctor, arguments.plugin_paths);
  doctor.footer(
      "Examples:\n"
      "  cogrsim doctor\n"
      "  cogrsim doctor --json | jq -r '.findings[] | select(.state != \"good\").remedy'\n"
      "Exit status: 0 nothing that is there is broken, 1 something is, or there is no engine.");
  doctor.callback([&] {
    DoctorOptions options;
    options.json = arguments.json;
    const auto commands = commands_of(app);
    options.has_studio = std::any_of(commands.begin(), commands.end(), [](const CLI::App* command) {
      return command->get_name() == "studio";
    });
    options.plugin_paths = plugin_paths_from(arguments);
    status = doctor_command(options);
  });
}

Problem unknown_subcommand(const CLI::App& app, const std::string& argument) {
  std::vector<std::string> names;
  std::string list;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_group().empty()) continue;  // not for people
    names.push_back(command->get_name());
    list += (list.empty() ? "" : ", ") + command->get_name();
  }
  const std::string nearest = nearest_name(argument, names);
  return Problem(
      fmt::format("there is no subcommand '{}'", argument), "",
      fmt::format("{}there are {}",
                  nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest), list));
}

std::string command_help(CLI::App& app, const std::string& name, bool man) {
  // help() of the program gives that of the command that was parsed.
  if (name.empty())
    return man ? man_page(app)
               : app.get_formatter()->make_help(&app, "cogrsim", CLI::AppFormatMode::Normal);
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == name)
      return man ? command_man_page(*command) : command->help("cogrsim");
  }
  throw UsageError("command", unknown_subcommand(app, name));
}

// What the table itself gives.
void add_table_pages(CLI::App& app, Arguments& arguments, int& status) {
  const auto print = [&status](const std::string& text) {
    const auto printed = print_output(text);
    status = printed ? kGood : refuse(printed.error());
  };
  CLI::App& help = *app.add_subcommand("help", "Show the help of a command, or of all as one page");
  help.add_option("command", arguments.command, "The command; without one, all are listed")
      ->type_name("COMMAND");
  CLI::Option* reference = help.add_flag("--reference", arguments.reference,
                                         "Print the reference of all commands (Markdown) instead");
  help.add_flag("--man", arguments.man, "Print it as a manual page (roff) instead")
      ->excludes(reference);
  help.footer(
      "Examples:\n"
      "  cogrsim help run\n"
      "  cogrsim help --reference > command-line.md\n"
      "  cogrsim help --man run | man -l -");
  help.callback([&app, &arguments, print] {
    print(arguments.reference ? reference_page(app)
                              : command_help(app, arguments.command, arguments.man));
  });

  CLI::App& completion =
      *app.add_subcommand("completion", "Print a script that completes command lines in a shell");
  completion.add_option("shell", arguments.shell, "The shell")
      ->required()
      ->check(CLI::IsMember(completion_shells()))
      ->type_name("SHELL");
  completion.footer(
      "Examples:\n"
      "  source <(cogrsim completion bash)\n"
      "  cogrsim completion bash > ~/.local/share/bash-completion/completions/cogrsim\n"
      "  cogrsim completion zsh > ~/.zfunc/_cogrsim      in a folder of $fpath\n"
      "  cogrsim completion fish > ~/.config/fish/completions/cogrsim.fish\n"
      "Packages install all three. Cameras, views, tests, plots, bodies and parameters are those "
      "of the scene "
      "or recording on the line.");
  completion.callback([&arguments, print] { print(completion_script(arguments.shell)); });
}

// Of all commands, of those that write files, and of those that run scenes.
void add_output_rules(CLI::App& command) {
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), command.get_name()) != names.end();
  };
  command.add_flag_callback(
      "-q,--quiet", be_quiet,
      "No progress and no text but warnings, errors, and results asked for with -");
  command
      .add_option_function<std::string>(
          "--color",
          [](const std::string& when) {
            set_colors(when == "always"  ? Colors::always
                       : when == "never" ? Colors::never
                                         : Colors::automatic);
          },
          "Colours of text: auto, where a terminal wants them, always or never; default: auto")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->type_name("auto|always|never");
  if (is_one_of({"explain", "pull", "new", "test-case", "run-case", "help", "completion"})) return;
  command.add_flag_callback("--overwrite", allow_overwriting,
                            "Outputs may replace files that CogRSim did not write");
  if (is_one_of({"check", "schema", "plugins", "doctor", "list"})) return;
  command
      .add_option_function<std::string>(
          "--output-dir",
          [](const std::string& folder) { setenv("COGRSIM_OUTPUT_DIR", folder.c_str(), 1); },
          "Folder for what a scene names itself: recordings, learners' tables; default: the "
          "scene's")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
}

// "--json ''" is a slip of a script, and not "no JSON".
void refuse_empty_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_expected_max() == 0 || option->check_name("--title")) continue;
    option->check([](const std::string& argument) {
      return argument.empty()
                 ? std::string("its value is empty\nhelp: give a value, or leave the option out")
                 : std::string();
    });
  }
}

}  // namespace

std::shared_ptr<CLI::App> command_table(const std::vector<AddCommands>& more, int& status) {
  struct Table {
    CLI::App app{"Robot simulation on several physics engines: one scene, every engine.",
                 "cogrsim"};
    Arguments arguments;
  };
  const auto table = std::make_shared<Table>();
  CLI::App& app = table->app;
  Arguments& arguments = table->arguments;
  app.set_version_flag("--version", "cogrsim " COGRSIM_VERSION);
  add_plugin_path(app, arguments.global_plugin_paths);
  app.require_subcommand(1);
  add_run(app, arguments, status);
  add_compare(app, arguments, status);
  add_plot(app, arguments, status);
  add_info(app, status);
  add_replay(app, status);
  add_check(app, arguments, status);
  add_sweep(app, status);
  add_test(app, status);
  add_map(app, status);
  add_render(app, status);
  for (const AddCommands add : more) add(app, status);
  add_new(app, status);
  add_import(app, status);
  add_policy(app, status);
  add_transfer(app, status);
  add_export(app, status);
  add_small_ones(app, arguments, status);
  add_table_pages(app, arguments, status);
  refuse_empty_values(app);
  for (CLI::App* command : app.get_subcommands({})) {
    add_output_rules(*command);
    refuse_empty_values(*command);
  }
  app.footer(
      "Examples:\n"
      "  cogrsim check robot.scene.xml\n"
      "  cogrsim run robot.scene.xml\n"
      "  cogrsim compare robot.scene.xml --backends bullet,cogrsim --report robot.html\n"
      "  cogrsim run --help      each subcommand has examples of its own\n"
      "Exit status: 0 good, 1 the scene or run failed, 2 wrong usage.");
  return {table, &app};
}

int run_command_line(int argc, char** argv, const std::vector<AddCommands>& more) {
  int status = kGood;
  const std::shared_ptr<CLI::App> table = command_table(more, status);
  CLI::App& app = *table;
  if (argc < 2) {
    std::fputs(app.help().c_str(), stderr);
    return kWrongUsage;
  }
  // Asked by the scripts of `cogrsim completion`, about any words: they are not parsed.
  if (std::string(argv[1]) == "complete") {
    std::vector<std::string> words(argv + 2, argv + argc);
    if (!words.empty() && words.front() == "--") words.erase(words.begin());
    const auto printed = print_output(to_text(complete(app, words)));
    return printed ? kGood : refuse(printed.error());
  }
  // CLI11 takes an empty value of an option that needs none for no value.
  for (int i = 2; i < argc; ++i)
    if (argv[i] == std::string("--json=") ||
        (argv[i][0] == '\0' && argv[i - 1] == std::string("--json"))) {
      print_error("--json: its value is empty\nhelp: give a file, or - for the standard output");
      return kWrongUsage;
    }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    std::ostringstream text;  // --help, --version
    app.exit(request, text, text);
    const auto printed = print_output(text.str());
    return printed ? kGood : refuse(printed.error());
  } catch (const CLI::ParseError& error) {
    const auto chosen = app.get_subcommands();
    const std::string command =
        chosen.empty() ? "cogrsim" : "cogrsim " + chosen.front()->get_name();
    std::string text = error.what();
    if (!chosen.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
      const std::vector<std::string> extra = chosen.front()->remaining();
      if (!extra.empty()) text = unexpected_argument(*chosen.front(), extra);
    }
    if (chosen.empty() && argv[1][0] != '-') text = unknown_subcommand(app, argv[1]).text();
    if (text.find("\nhelp: ") == std::string::npos) text += "\nhelp: see " + command + " --help";
    print_error(text);
    return kWrongUsage;
  }
  return status;
}

}  // namespace cogrsim::cli
