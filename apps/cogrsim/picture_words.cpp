#include "picture_words.h"

#include <charconv>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "options.h"
#include "quantities.h"
#include "words.h"

namespace cogrsim::cli {
namespace {

// Words as they were typed.
struct PictureWords {
  std::string scene, backend, step, seed, at, every, speed, output, area, size;
  std::vector<std::string> set, plugin_paths, trails, overlays;
  std::string camera, view;
  int width = 900;
  bool no_names = false, no_rays = false, depth = false, segmentation = false, no_shadows = false;
};

[[noreturn]] void refuse_words(const std::string& option, const std::string& what,
                               const std::string& way_out) {
  throw CLI::ValidationError(option, what + "\nhelp: " + way_out);
}

double time_from(const std::string& option, const std::string& word, bool zero_is_fine) {
  const auto time = parse_time(word);
  if (!time) throw CLI::ValidationError(option, time.error().text());
  if (*time < 0.0 || *time > kLongestDuration || (*time == 0.0 && !zero_is_fine)) {
    refuse_words(option, fmt::format("'{}' is out of range", word),
                 zero_is_fine ? "a time from 0 to 1e9 s" : "a time above 0 and at most 1e9 s");
  }
  return *time;
}

FrameSourceOptions source_from(const PictureWords& words) {
  FrameSourceOptions options;
  options.source.scene = words.scene;
  options.source.plugin_paths = words.plugin_paths;
  options.source.set = settings_from(words.set);
  if (!words.seed.empty()) options.source.seed = seed_from(words.seed);
  options.backend = words.backend;
  if (!words.step.empty()) options.step = step_from(words.step);
  return options;
}

double speed_from(const PictureWords& words) {
  if (words.speed.empty()) return 1.0;
  const auto speed = parse_number(words.speed);
  if (!speed || !(*speed > 0.0)) {
    refuse_words("--speed", fmt::format("'{}' is no speed", words.speed),
                 "write how much faster than life the film runs, such as 1, 4 or 0.25");
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
    refuse_words("--area", fmt::format("'{}' is no area", text),
                 "write x and y of the lower left and the upper right corner: --area -2,-1,2,1");
  }
  return {values[0], values[1], values[2], values[3]};
}

void size_from(const std::string& text, RenderCommandOptions& options) {
  const std::vector<std::string> parts = split(text, 'x');
  const auto read = [](const std::string& word, int& out) {
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    return error == std::errc{} && rest == word.data() + word.size() && out > 0;
  };
  if (parts.size() != 2 || !read(parts[0], options.width) || !read(parts[1], options.height)) {
    refuse_words("--size", fmt::format("'{}' is no size", text), "write pixels, such as 1280x720");
  }
}

void add_common(CLI::App& command, PictureWords& words) {
  command.add_option("source", words.scene, "Scene file or recording (.mcap)")
      ->required()
      ->type_name("SCENE|RUN.mcap");
  command.add_option("--at", words.at, "Time of the picture; default: the end")->type_name("T");
  command.add_option("-o,--output", words.output, "File to write")->required()->type_name("FILE");
  command.add_option("--every", words.every, "Of a film: simulated time between its pictures")
      ->type_name("DT");
  command.add_option("--speed", words.speed, "Of a film: how much faster than life; default: 1")
      ->type_name("X");
  command.add_option("-b,--backend", words.backend, "Of a scene: physics engine")->type_name("B");
  command.add_option("--step", words.step, "Of a scene: step length")->type_name("DT");
  command.add_option("--seed", words.seed, "Of a scene: seed of all randomness")->type_name("N");
  command.add_option("--set", words.set, "Of a scene: value of a <param>; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--plugin-path", words.plugin_paths,
                  "Folder in which plugins are looked for first; may be repeated")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::vector<std::string> listed(const std::vector<std::string>& lists) {
  std::vector<std::string> out;
  for (const std::string& list : lists) {
    for (const std::string& word : split(list, ',')) {
      if (!word.empty()) out.push_back(word);
    }
  }
  return out;
}

}  // namespace

void add_map(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("map", "Draw the plan view with the robots' paths");
  const auto words = std::make_shared<PictureWords>();
  add_common(command, *words);
  command.add_option("--width", words->width, "Of the drawing, in pixels")
      ->check(CLI::Range(64, 8000))
      ->type_name("PIXELS")
      ->capture_default_str();
  command.add_option("--area", words->area, "What to show; default: everything")
      ->type_name("X,Y,X,Y");
  command.add_option("--trail", words->trails, "Body or assembly to follow; default: the robots")
      ->type_name("NAME,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--no-names", words->no_names, "Without names");
  command.add_flag("--no-rays", words->no_rays, "Without the sensors' rays");
  command.footer(
      "Examples:\n"
      "  cogrsim map run.mcap -o map.svg\n"
      "  cogrsim map run.mcap --at 12.5 -o map.png\n"
      "  cogrsim map robot.scene.xml --backend cogrsim --at 3 -o map.pdf\n"
      "  cogrsim map run.mcap --every 0.1 --speed 4 -o run.gif      (or .mp4, .webm)\n"
      "A scene is run up to the time asked for.");
  command.callback([words, &status] {
    MapCommandOptions options;
    options.source = source_from(*words);
    if (!words->at.empty()) options.at = time_from("--at", words->at, true);
    if (!words->every.empty()) options.every = time_from("--every", words->every, false);
    options.speed = speed_from(*words);
    options.output = words->output;
    options.width = words->width;
    if (!words->area.empty()) options.area = area_from(words->area);
    options.trails = listed(words->trails);
    options.names = !words->no_names;
    options.rays = !words->no_rays;
    status = map_command(options);
  });
}

void add_render(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand("render", "Take a picture, or a film");
  const auto words = std::make_shared<PictureWords>();
  add_common(command, *words);
  command.add_option("--camera", words->camera, "Through this camera of the scene")
      ->type_name("NAME");
  command
      .add_option("--view", words->view,
                  "From a <view> of the scene, or front, back, left, right, top, bottom; default: "
                  "iso")
      ->type_name("NAME");
  command.add_option("--size", words->size, "Of the picture in pixels; default: the camera's own")
      ->type_name("WxH");
  command.add_flag("--depth", words->depth, "Depth in millimetres, as 16-bit grey PNG; 0: nothing");
  command.add_flag("--segmentation", words->segmentation,
                   "A colour for every body; what they mean is printed");
  command
      .add_option("--overlay", words->overlays,
                  "Drawn over it: rays, contacts, frames, labels, trails")
      ->type_name("WHAT,...")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_flag("--no-shadows", words->no_shadows, "Without shadows");
  command.footer(
      "Examples:\n"
      "  cogrsim render robot.scene.xml --at 2 -o picture.png\n"
      "  cogrsim render run.mcap --camera bot.eye --at 12.5 -o eye.png\n"
      "  cogrsim render run.mcap --camera bot.eye --depth -o depth.png\n"
      "  cogrsim render run.mcap --view top --overlay rays,labels,trails -o top.png\n"
      "  cogrsim render run.mcap --every 0.05 -o run.mp4\n"
      "A scene is run up to the time asked for; a recording is not computed again.");
  command.callback([words, &status] {
    RenderCommandOptions options;
    options.source = source_from(*words);
    if (!words->at.empty()) options.at = time_from("--at", words->at, true);
    if (!words->every.empty()) options.every = time_from("--every", words->every, false);
    options.speed = speed_from(*words);
    options.output = words->output;
    options.camera = words->camera;
    options.view = words->view;
    if (!words->size.empty()) size_from(words->size, options);
    options.depth = words->depth;
    options.segmentation = words->segmentation;
    options.overlays = listed(words->overlays);
    options.shadows = !words->no_shadows;
    status = render_command(options);
  });
}

}  // namespace cogrsim::cli
