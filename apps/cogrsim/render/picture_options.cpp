#include "render/picture_options.h"

#include <charconv>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/arguments.h"
#include "common/options.h"
#include "common/quantities.h"

namespace cogrsim::cli {
namespace {

// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

// Arguments as they were typed.
struct PictureArguments {
  std::string scene, backend, step, seed, at, every, speed, output, area, size;
  std::vector<std::string> set, without, plugin_paths, trails, overlays;
  std::string camera, view;
  int width = 900;
  bool no_names = false, no_rays = false, depth = false, segmentation = false, no_shadows = false;
};

[[noreturn]] void refuse_argument(const std::string& option, const std::string& what,
                                  const std::string& remedy) {
  throw UsageError(option, Problem(what, "", remedy));
}

// --at and --every into the options of a picture.
template <class Options>
void take_times(const PictureArguments& arguments, Options& options) {
  if (!arguments.at.empty()) {
    options.at = time_from("--at", arguments.at, 0.0, kLongestDuration, "a time from 0 to 1e9 s");
  }
  if (!arguments.every.empty()) {
    options.every = time_from("--every", arguments.every, kAboveZero, kLongestDuration,
                              "a time above 0 and at most 1e9 s");
  }
}

FrameSourceOptions source_from(const PictureArguments& arguments) {
  FrameSourceOptions options;
  options.source.scene = arguments.scene;
  options.source.plugin_paths = arguments.plugin_paths;
  options.source.set = settings_from(arguments.set);
  options.source.without = without_from(arguments.without);
  if (!arguments.seed.empty()) options.source.seed = seed_from(arguments.seed);
  options.backend = arguments.backend;
  if (!arguments.step.empty()) options.step = step_from(arguments.step);
  return options;
}

double speed_from(const PictureArguments& arguments) {
  if (arguments.speed.empty()) return 1.0;
  const auto speed = parse_number(arguments.speed);
  if (!speed || !(*speed > 0.0)) {
    refuse_argument("--speed", fmt::format("'{}' is not a speed", arguments.speed),
                    "write it as a multiple of real time, such as 1, 4 or 0.25");
  }
  return *speed;
}

MapArea area_from(const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  std::vector<double> values;
  for (const std::string& part : parts) {
    const auto value = parse_length_or_angle(part);
    if (value && value->dimension == Dimension::length) values.push_back(value->value);
  }
  if (parts.size() != 4 || values.size() != 4 || values[0] >= values[2] || values[1] >= values[3]) {
    refuse_argument("--area", fmt::format("'{}' is not an area", text),
                    "write x and y of the lower left and the upper right corner: --area -2,-1,2,1");
  }
  return {values[0], values[1], values[2], values[3]};
}

void size_from(const std::string& text, RenderCommandOptions& options) {
  const std::vector<std::string> parts = split(text, 'x');
  const auto read = [](const std::string& argument, int& out) {
    const char* const end = argument.data() + argument.size();
    const auto [rest, error] = std::from_chars(argument.data(), end, out);
    return error == std::errc{} && rest == end && out > 0;
  };
  if (parts.size() != 2 || !read(parts[0], options.width) || !read(parts[1], options.height)) {
    refuse_argument("--size", fmt::format("'{}' is not a size", text),
                    "write pixels, such as 1280x720");
  }
}

void add_common(CLI::App& command, PictureArguments& arguments) {
  command.add_option("source", arguments.scene, "Scene file or recording (.mcap)")
      ->required()
      ->type_name("SCENE|RUN.mcap");
  command.add_option("--at", arguments.at, "Time of the picture; default: the end")->type_name("T");
  command.add_option("-o,--output", arguments.output, "File to write")
      ->required()
      ->type_name("FILE");
  command.add_option("--every", arguments.every, "Simulated time between the pictures of a film")
      ->type_name("DT");
  command.add_option("--speed", arguments.speed, "Speed of a film; 1, the default, is real time")
      ->type_name("X");
  command.add_option("-b,--backend", arguments.backend, "Physics engine of a scene")
      ->type_name("B");
  command.add_option("--step", arguments.step, "Step length of a scene")->type_name("DT");
  command.add_option("--seed", arguments.seed, "Seed of all randomness of a scene")->type_name("N");
  command.add_option("--set", arguments.set, "Value of a <param> of a scene; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_without(command, arguments.without);
  command
      .add_option("--plugin-path", arguments.plugin_paths,
                  "Folder in which plugins are looked for first; may be repeated")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::vector<std::string> listed(const std::vector<std::string>& lists) {
  std::vector<std::string> out;
  for (const std::string& list : lists) {
    for (const std::string& argument : split(list, ',')) {
      if (!argument.empty()) out.push_back(argument);
    }
  }
  return out;
}

}  // namespace

void add_map(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("map", "Draw the plan view with the robots' paths");
  const auto arguments = std::make_shared<PictureArguments>();
  add_common(command, *arguments);
  command.add_option("--width", arguments->width, "Size of the drawing in pixels")
      ->check(CLI::Range(64, 8000))
      ->type_name("PIXELS")
      ->capture_default_str();
  command.add_option("--area", arguments->area, "Area to show; default: everything")
      ->type_name("X,Y,X,Y");
  command
      .add_option("--trail", arguments->trails, "Body or assembly to follow; default: the robots")
      ->type_name("NAME,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--no-names", arguments->no_names, "Draw no names");
  command.add_flag("--no-rays", arguments->no_rays, "Draw no rays of sensors");
  command.footer(
      "Examples:\n"
      "  cogrsim map run.mcap -o map.svg\n"
      "  cogrsim map run.mcap --at 12.5 -o map.png\n"
      "  cogrsim map robot.scene.xml --backend cogrsim --at 3 -o map.pdf\n"
      "  cogrsim map run.mcap --every 0.1 --speed 4 -o run.gif      (or .mp4, .webm)\n"
      "A scene is run up to the time asked for.");
  command.callback([arguments, &status] {
    MapCommandOptions options;
    options.source = source_from(*arguments);
    take_times(*arguments, options);
    options.speed = speed_from(*arguments);
    options.output = arguments->output;
    options.width = arguments->width;
    if (!arguments->area.empty()) options.area = area_from(arguments->area);
    options.trails = listed(arguments->trails);
    options.names = !arguments->no_names;
    options.rays = !arguments->no_rays;
    status = map_command(options);
  });
}

void add_render(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("render", "Render a picture or a film");
  const auto arguments = std::make_shared<PictureArguments>();
  add_common(command, *arguments);
  command.add_option("--camera", arguments->camera, "Camera of the scene")->type_name("NAME");
  command
      .add_option("--view", arguments->view,
                  "From a <view> of the scene, or front, back, left, right, top, bottom; default: "
                  "iso")
      ->type_name("NAME");
  command
      .add_option("--size", arguments->size,
                  "Size of the picture in pixels; default: the camera's own")
      ->type_name("WxH");
  command.add_flag("--depth", arguments->depth,
                   "Write the depth in millimetres, as 16-bit grey PNG; 0: nothing");
  command.add_flag("--segmentation", arguments->segmentation,
                   "Draw a colour for every body; the colours are listed");
  command
      .add_option("--overlay", arguments->overlays,
                  "Overlays: rays, contacts, frames, labels, trails")
      ->type_name("WHAT,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--no-shadows", arguments->no_shadows, "Draw no shadows");
  command.footer(
      "Examples:\n"
      "  cogrsim render robot.scene.xml --at 2 -o picture.png\n"
      "  cogrsim render run.mcap --camera bot.eye --at 12.5 -o eye.png\n"
      "  cogrsim render run.mcap --camera bot.eye --depth -o depth.png\n"
      "  cogrsim render run.mcap --view top --overlay rays,labels,trails -o top.png\n"
      "  cogrsim render run.mcap --every 0.05 -o run.mp4\n"
      "A scene is run up to the time asked for; a recording is not computed again.");
  command.callback([arguments, &status] {
    RenderCommandOptions options;
    options.source = source_from(*arguments);
    take_times(*arguments, options);
    options.speed = speed_from(*arguments);
    options.output = arguments->output;
    options.camera = arguments->camera;
    options.view = arguments->view;
    if (!arguments->size.empty()) size_from(arguments->size, options);
    options.depth = arguments->depth;
    options.segmentation = arguments->segmentation;
    options.overlays = listed(arguments->overlays);
    options.shadows = !arguments->no_shadows;
    status = render_command(options);
  });
}

}  // namespace cogrsim::cli
