#include "studio_words.h"

#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "frames.h"
#include "studio_command.h"
#include "words.h"

namespace cogrsim::studio {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

struct StudioWords {
  std::string step, seed;
  std::vector<std::string> set;
  bool no_open = false;
  bool keep_token = false, new_token = false;
  StudioOptions options;
};

StudioOptions options_from(const StudioWords& words) {
  StudioOptions options = words.options;
  options.open = !words.no_open;
  if (words.keep_token || words.new_token) options.keep_token = words.keep_token;
  options.parameters = cli::settings_from(words.set);
  if (!words.step.empty()) options.step = cli::step_from(words.step);
  if (!words.seed.empty()) options.seed = cli::seed_from(words.seed);
  if (cli::is_recording(options.file)) {
    const char* word = !options.backend.empty() ? "--backend"
                       : options.step > 0.0     ? "--step"
                       : options.seed           ? "--seed"
                       : !words.set.empty()     ? "--set"
                       : options.allow_build    ? "--allow-build"
                                                : nullptr;
    if (word) {
      throw cli::UsageError(word, Problem("a recording is looked at as it was made", "",
                                          "leave it out, or open the scene"));
    }
  }
  return options;
}

}  // namespace

void add_studio(CLI::App& app, int& status) {
  CLI::App& command =
      *app.add_subcommand("studio", "See, edit and steer a scene, or a recording, in the browser");
  const auto words = std::make_shared<StudioWords>();
  command
      .add_option("file", words->options.file,
                  "Scene file, NAME.scene.xml, made when it is not there; or a recording")
      ->required()
      ->type_name("SCENE|RUN.mcap");
  command
      .add_option("--host", words->options.host,
                  "Address to listen at; any but 127.0.0.1 lets others in the network in, with the "
                  "token")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command
      .add_option("--port", words->options.port,
                  "Default: the first free one from 8642 to 8651, else any")
      ->type_name("N")
      ->check(CLI::Range(1, 65535));
  command.add_flag("--no-open", words->no_open, "Open no browser, print the address alone");
  CLI::Option* keep = command.add_flag(
      "--keep-token", words->keep_token,
      "Have the address of the last start at this port, if it ended less than a day ago, so that "
      "pages that are still open go on; so it is without --allow-build and --host");
  command
      .add_flag("--new-token", words->new_token,
                "Have another address than after the last start, which holds no longer")
      ->excludes(keep);
  command
      .add_option("-b,--backend", words->options.backend, "Physics engine; default: the scene's")
      ->type_name("B");
  command
      .add_option("--step", words->step,
                  "Step length, such as 0.001 or \"1 ms\"; default: the scene's")
      ->type_name("DT");
  command.add_option("--seed", words->seed, "Seed of all randomness; default: the scene's")
      ->type_name("N");
  cli::add_list(command, "--set", words->set,
                "Value of a <param> of the scene, in the scene's own notation; may be repeated",
                "NAME=VALUE");
  command.add_flag(
      "--allow-build", words->options.allow_build,
      "Let the page build the controllers beside the scene, which runs what is in them");
  cli::add_list(command, "--plugin-path", words->options.plugin_paths,
                "Folder in which plugins and backends are looked for first; may be repeated",
                "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim studio robot.scene.xml\n"
      "  cogrsim studio new.scene.xml                   an empty scene to build in\n"
      "  cogrsim studio robot.scene.xml --backend bullet --step \"1 ms\" --set load=2kg\n"
      "  cogrsim studio robot.mcap                      a run that was recorded\n"
      "  cogrsim studio robot.scene.xml --no-open --port 8080\n"
      "  ssh -L 8080:127.0.0.1:8080 host                then, on another machine, the same "
      "address\n"
      "The first line of the standard output is the address. It contains a token: whoever has it "
      "may\n"
      "do everything. Ctrl-C ends the studio; what was not saved is kept beside the scene, and "
      "offered "
      "when\n"
      "it is opened again.");
  command.callback([words, &status] { status = studio_command(options_from(*words)); });
}

}  // namespace cogrsim::studio
