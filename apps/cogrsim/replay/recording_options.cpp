#include "replay/recording_options.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "common/arguments.h"
#include "common/options.h"

namespace cogrsim::cli {

void add_info(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("info", "Describe a recording");
  const auto options = std::make_shared<InfoOptions>();
  command.add_option("file", options->file, "Recording")->required()->type_name("RUN.mcap");
  add_json(command, options->json);
  command
      .add_option("--extract", options->extract,
                  "Write the scene and all other attached files into this folder")
      ->type_name("DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim info run.mcap\n"
      "  cogrsim info run.mcap --json | jq .frames\n"
      "  cogrsim info run.mcap --extract scene      the scene as it was run");
  command.callback([options, &status] { status = info_command(*options); });
}

void add_replay(CLI::App& app, int& status) {
  struct ReplayArguments {
    ReplayOptions options;
    std::string at, every;
  };
  CLI::App& command =
      *app.add_subcommand("replay", "Read a recorded run: frames, tables, pictures");
  const auto arguments = std::make_shared<ReplayArguments>();
  ReplayOptions& options = arguments->options;
  command.add_option("file", options.file, "Recording")->required()->type_name("RUN.mcap");
  add_json(command, options.json, "Write the frames as JSON, one to a line");
  command.add_option("--csv", options.csv, "Tables for spreadsheets and scripts, into this folder")
      ->type_name("DIR");
  command
      .add_option("--ros2", options.ros2,
                  "Messages of ROS 2 in an MCAP file, which ros2 bag, RViz and others read")
      ->type_name("FILE.mcap");
  command
      .add_option("--render", options.render,
                  "Pictures of a camera, or from a view (also front, back, left, right, top, "
                  "bottom, iso); may be repeated")
      ->type_name("CAMERA|VIEW")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("-o,--output", options.output, "Folder for the pictures")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_option("--every", arguments->every, "Time between pictures of a view; default: 0.04 s")
      ->type_name("DT");
  command.add_option("--at", arguments->at,
      "Use only the frame at this time, or the last one before it")
      ->type_name("T");
  command.add_flag("--recompute", options.recompute,
                   "Compute all readings again from the frames, instead of taking those on "
                   "file");
  command.add_flag("--verify", options.verify,
                   "Compute all readings again and compare them with those on file");
  command
      .add_option("--plugin-path", options.plugin_paths,
                  "Folder in which plugins are looked for first; may be repeated")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.footer(
      "Examples:\n"
      "  cogrsim replay run.mcap --at 2.5 --json - | jq .bodies\n"
      "  cogrsim replay run.mcap --json - | jq -c '[.time, .sensors[\"bot.ir\"].values.distance]'\n"
      "  cogrsim replay run.mcap --csv tables\n"
      "  cogrsim replay run.mcap --ros2 bag.mcap      then: ros2 bag play bag.mcap\n"
      "  cogrsim replay run.mcap --render bot.eye --render top -o pictures\n"
      "  cogrsim replay run.mcap --verify      readings depend on nothing but the frames");
  command.callback([arguments, &status] {
    ReplayOptions& chosen = arguments->options;
    if (!arguments->at.empty()) chosen.at = time_from("--at", arguments->at);
    if (!arguments->every.empty()) {
      chosen.every = time_from("--every", arguments->every);
      if (chosen.every <= 0.0) {
        throw CLI::ValidationError("--every", "'" + arguments->every + "' is not greater than zero");
      }
    }
    if (chosen.json.empty() && chosen.csv.empty() && chosen.ros2.empty() && chosen.render.empty() &&
        !chosen.verify) {
      throw CLI::ValidationError(
          "replay",
          "no output is asked for\nhelp: ask for --json, --csv, --ros2, --render "
          "or --verify; cogrsim info lists what is in the file");
    }
    status = replay_command(chosen);
  });
}

}  // namespace cogrsim::cli
