#include "studio_options.h"

#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "render/frames.h"
#include "studio_command.h"
#include "common/arguments.h"

namespace cogrsim::studio {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

struct StudioArguments {
  std::string step, seed, isolation;
  std::vector<std::string> set, without;
  bool no_open = false;
  bool keep_token = false, new_token = false;
  StudioOptions options;
};

StudioOptions options_from(const StudioArguments& arguments) {
  StudioOptions options = arguments.options;
  options.open = !arguments.no_open;
  if (arguments.keep_token || arguments.new_token) options.keep_token = arguments.keep_token;
  options.parameters = cli::settings_from(arguments.set);
  if (!arguments.step.empty()) options.step = cli::step_from(arguments.step);
  if (!arguments.seed.empty()) options.seed = cli::seed_from(arguments.seed);
  options.without = cli::without_from(arguments.without);
  if (arguments.isolation == "none") options.isolation = Isolation::none;
  if (cli::is_recording(options.file)) {
    const char* argument = !options.backend.empty()       ? "--backend"
                           : options.step > 0.0           ? "--step"
                           : options.seed                 ? "--seed"
                           : !arguments.set.empty()       ? "--set"
                           : !options.without.empty()     ? "--without"
                           : options.allow_build          ? "--allow-build"
                           : !arguments.isolation.empty() ? "--isolation"
                                                          : nullptr;
    if (argument) {
      throw cli::UsageError(argument, Problem("a recording cannot be run again", "",
                                          "leave it out, or open the scene"));
    }
  }
  return options;
}

}  // namespace

void add_studio(CLI::App& app, int& status) {
  CLI::App& command =
      *app.add_subcommand("studio", "See, edit and steer a scene, or a recording, in the browser");
  const auto arguments = std::make_shared<StudioArguments>();
  command
      .add_option("file", arguments->options.file,
                  "Scene file, NAME.scene.xml, which is made if it does not exist; or a recording. "
                  "Without one a start page opens")
      ->type_name("SCENE|RUN.mcap");
  command
      .add_option("--host", arguments->options.host,
                  "Address to listen at; any but 127.0.0.1 lets others in the network in, with the "
                  "token")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command
      .add_option("--port", arguments->options.port,
                  "Default: the first free one from 8642 to 8651, else any")
      ->type_name("N")
      ->check(CLI::Range(1, 65535));
  command.add_flag("--no-open", arguments->no_open, "Open no browser, only print the address");
  CLI::Option* keep = command.add_flag(
      "--keep-token", arguments->keep_token,
      "Keep the address of the last start at this port, if it ended less than a day ago, so that "
      "pages that are still open reconnect; the default without --allow-build and --host");
  command
      .add_flag("--new-token", arguments->new_token,
                "Use a new address; the one of the last start is no longer valid")
      ->excludes(keep);
  command
      .add_option("-b,--backend", arguments->options.backend, "Physics engine; default: the scene's")
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
  command
      .add_option("--isolation", arguments->isolation,
                  "Where controllers run whose <controller> does not say: \"process\", each in a "
                  "process of its own (default), or \"none\", in the studio's, which their crash "
                  "ends")
      ->type_name("process|none")
      ->check(CLI::IsMember({"process", "none"}));
  command.add_flag(
      "--allow-build", arguments->options.allow_build,
      "Let the page build and debug the controllers beside the scene, which runs their code");
  cli::add_list(command, "--plugin-path", arguments->options.plugin_paths,
                "Folder in which plugins and backends are looked for first; may be repeated",
                "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim studio                                 a page to start from\n"
      "  cogrsim studio robot.scene.xml\n"
      "  cogrsim studio new.scene.xml                   an empty scene to build in\n"
      "  cogrsim studio robot.scene.xml --backend bullet --step \"1 ms\" --set load=2kg\n"
      "  cogrsim studio robot.mcap                      a run that was recorded\n"
      "  cogrsim studio robot.scene.xml --no-open --port 8080\n"
      "  ssh -L 8080:127.0.0.1:8080 host                then, on another machine, the same "
      "address\n"
      "The first line of the standard output is the address. It contains a token: whoever has it\n"
      "can do everything. Ctrl-C ends the studio; unsaved changes are kept beside the scene, and\n"
      "offered when it is opened again.");
  command.callback([arguments, &status] { status = studio_command(options_from(*arguments)); });
}

}  // namespace cogrsim::studio
