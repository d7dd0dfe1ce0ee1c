#include "bundle_options.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "bundle_command.h"
#include "render/frames.h"
#include "common/arguments.h"

namespace cogrsim::studio {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

struct BundleArguments {
  std::string step, seed, duration, every;
  std::vector<std::string> set, without;
  BundleOptions options;
};

BundleOptions options_from(const BundleArguments& arguments) {
  BundleOptions options = arguments.options;
  cli::SceneOptions& source = options.source.source;
  source.set = cli::settings_from(arguments.set);
  source.without = cli::without_from(arguments.without);
  if (!arguments.step.empty()) options.source.step = cli::step_from(arguments.step);
  if (!arguments.seed.empty()) source.seed = cli::seed_from(arguments.seed);
  if (!arguments.duration.empty()) {
    source.duration =
        cli::time_from("--duration", arguments.duration, cli::kSmallestStep, cli::kLongestDuration,
                       "a run lasts more than 0 s and at most 1e9 s");
  }
  if (!arguments.every.empty()) {
    options.every = cli::time_from("--every", arguments.every, 0.0, cli::kLongestDuration,
                                   "write a time, or 0 for every step");
  }
  if (cli::is_recording(source.scene)) {
    const char* argument = !options.source.backend.empty() ? "--backend"
                           : options.source.step > 0.0     ? "--step"
                           : source.seed                   ? "--seed"
                           : !arguments.set.empty()        ? "--set"
                           : !source.without.empty()       ? "--without"
                                                           : nullptr;
    if (argument) {
      throw cli::UsageError(argument, Problem("a recording is bundled as it was made", "",
                                          "leave it out, or bundle the scene"));
    }
  }
  return options;
}

}  // namespace

void add_bundle(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand(
      "bundle", "Put a run into one page that opens from disk, without a network");
  const auto arguments = std::make_shared<BundleArguments>();
  BundleOptions& options = arguments->options;
  command
      .add_option("file", options.source.source.scene,
                  "Scene file, which is run, or a recording, which is read")
      ->required()
      ->type_name("SCENE|RUN.mcap");
  command
      .add_option(
          "-o,--output", options.output,
          "The page; default: the scene's name with .html, in this folder; -: standard output")
      ->type_name("FILE");
  command.add_flag("--force", options.force, "The same as --overwrite");
  command
      .add_option(
          "-d,--duration", arguments->duration,
          "How much of the run, such as 5 or \"2 min\"; default: the scene's, else 10 s; of "
          "a recording all")
      ->type_name("T");
  command
      .add_option("--every", arguments->every,
                  "Time between frames, 0: every step; default: 1/60 s, as a display shows them")
      ->type_name("T");
  command
      .add_option(
          "--size", options.size,
          "Largest size of frames and curves before they are compressed [MB]; of a longer run "
          "every second frame is left out, again and again")
      ->type_name("MB")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      .add_option("-b,--backend", options.source.backend, "Physics engine; default: the scene's")
      ->type_name("B");
  command
      .add_option("--step", arguments->step,
                  "Step length, such as 0.001 or \"1 ms\"; default: the scene's")
      ->type_name("DT");
  command.add_option("--seed", arguments->seed, "Seed of all randomness; default: the scene's")
      ->type_name("N");
  cli::add_list(command, "--set", arguments->set,
                "Value of a <param> of the scene, in the scene's own notation; may be repeated",
                "NAME=VALUE");
  cli::add_without(command, arguments->without);
  cli::add_list(command, "--plugin-path", options.source.source.plugin_paths,
                "Folder in which plugins and backends are looked for first; may be repeated",
                "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim bundle robot.scene.xml -o robot.html\n"
      "  cogrsim bundle robot.scene.xml --backend cogrsim --duration 30s --set load=2kg\n"
      "  cogrsim bundle robot.scene.xml --every 0         every step\n"
      "  cogrsim bundle robot.mcap                        a run that was recorded, with its "
      "pictures\n"
      "The page shows the run in 3D and as a map, with its timeline, curves, figures, events and\n"
      "the scene's text. It needs nothing but itself. A run that fails is bundled as far as it "
      "came;\n"
      "the exit status is 1 then.");
  command.callback([arguments, &status] { status = bundle_command(options_from(*arguments)); });
}

}  // namespace cogrsim::studio
