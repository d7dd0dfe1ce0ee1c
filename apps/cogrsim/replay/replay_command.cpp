// cogrsim replay: a recorded run again, as numbers, tables and pictures.
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/recording/ros2_writer.h"
#include "cogrsim/rendering/framing.h"
#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/sensing/sensor_models.h"
#include "render/film.h"
#include "run/frame_json.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "render/picture_file.h"
#include "replay/recording_options.h"
#include "common/refuse.h"
#include "replay/replay_tables.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

// One JSON document to a line.
class JsonLines {
 public:
  static Result<JsonLines> create(const std::string& path) {
    JsonLines lines;
    if (path == "-") return lines;
    auto file = OutputFile::create(path, OutputKind::json, output_rules());
    if (!file) return tl::unexpected(file.error());
    lines.file_.emplace(std::move(*file));
    return lines;
  }
  void add(const Json& json) {
    if (!done_) return;
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    done_ =
        !file_ ? print_output(line) : file_->append(first_ ? marked(OutputKind::json, line) : line);
    first_ = false;
  }
  Result<> finish() { return done_ && file_ ? file_->commit() : done_; }

 private:
  JsonLines() = default;
  std::optional<OutputFile> file_;  // empty: the standard output
  Result<> done_;
  bool first_ = true;
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

// The difference between a reading on file and the one computed again; empty: none. Pictures that
// were not kept are not compared.
std::string difference(const Reading& a, const Reading& b) {
  if (a.sequence != b.sequence || a.time != b.time) return "when it was read";
  if (a.valid != b.valid) return "whether it is valid";
  if (!same_bits(a.values, b.values)) return "its values";
  if (a.contacts.size() != b.contacts.size()) return "its contacts";
  if (!a.picture || !b.picture) return "";
  const Picture &x = *a.picture, &y = *b.picture;
  if (x.color.data != y.color.data) return "its picture";
  const bool same_depth =
      x.depth.size() == y.depth.size() &&
      (x.depth.empty() || std::memcmp(x.depth.data(), y.depth.data(), 4 * x.depth.size()) == 0);
  return same_depth && x.bodies == y.bodies ? "" : "its picture";
}

// Compares readings with those on file, and prints the result.
class Verification {
 public:
  explicit Verification(Recording& recording) : recording_(recording) {}

  void compare(const Frame& computed) {
    const auto recorded = recording_.frame(index_++);
    if (!recorded) return;
    seen_.resize(std::max(seen_.size(), computed.readings.size()));
    for (std::size_t i = 0; i < computed.readings.size(); ++i) {
      const Reading &a = (*recorded)->readings[i], &b = computed.readings[i];
      if (a.sequence == seen_[i] && b.sequence == seen_[i]) continue;
      seen_[i] = a.sequence;
      ++readings_;
      const std::string what = difference(a, b);
      if (what.empty()) continue;
      if (differences_++ == 0) {
        first_ = fmt::format("sensor '{}' at {}: {} differ{}", computed.model->sensors[i].name,
                             time_text(computed.time), what, what == "its values" ? "" : "s");
      }
    }
  }

  int report() const {
    if (differences_ == 0) {
      std::fputs(fmt::format("{} readings of {} sensors computed again, all equal\n", readings_,
                             seen_.size())
                     .c_str(),
                 stderr);
      return kGood;
    }
    print_error(
        fmt::format("{} of {} readings are not what was recorded; first: {}\n"
                    "help: colours that were recorded as JPEG are never equal; otherwise "
                    "a sensor's plugin is another version than in the run",
                    differences_, readings_, first_));
    return kFailed;
  }

 private:
  Recording& recording_;
  std::size_t index_ = 0;
  std::vector<std::uint64_t> seen_;
  std::size_t readings_ = 0, differences_ = 0;
  std::string first_;
};

// ---- pictures

struct PictureSource {
  const ReplayOptions& options;
  Recording& recording;
  PluginLoader& loader;
  std::shared_ptr<Renderer> renderer;  // loaded when first needed
  std::size_t pictures = 0;
};

Result<Picture> rendered(PictureSource& source, const Frame& frame, const RenderRequest& request) {
  if (!source.renderer) {
    auto loaded = load_renderer(source.loader);
    if (!loaded) return tl::unexpected(loaded.error());
    source.renderer = *loaded;
  }
  auto pictures = source.renderer->render(frame, {request});
  if (!pictures) return tl::unexpected(pictures.error());
  return std::move(pictures->front());
}

Result<> save(PictureSource& source, const Picture& picture, const std::string& name,
              std::size_t number) {
  const auto put = [&](const char* part, const Result<std::string>& bytes) -> Result<> {
    if (!bytes) return tl::unexpected(bytes.error());
    ++source.pictures;
    return write_output(
        fmt::format("{}/{}_{:06}{}.png", source.options.output, name, number, part),
        OutputKind::png, *bytes);
  };
  Result<> done;
  if (!picture.color.data.empty()) done = put("", encode_png(picture.color));
  if (done && !picture.depth.empty()) done = put("_depth", depth_png(picture));
  if (done && !picture.bodies.empty()) {
    done = put("_segmentation", segmentation_png(picture));
  }
  return done;
}

// Every picture a camera took, from the file, or taken again where pictures were not kept.
Result<> camera_pictures(PictureSource& source, std::size_t sensor) {
  std::uint64_t last = 0;
  std::size_t first_frame = 0, end = source.recording.frame_count();
  if (source.options.at) {
    first_frame = source.recording.index_at(*source.options.at);
    end = first_frame + 1;
  }
  for (std::size_t i = first_frame; i < end && !interrupted(); ++i) {
    const auto frame = source.recording.frame(i);
    if (!frame) return tl::unexpected(frame.error());
    if (sensor >= (*frame)->readings.size()) continue;
    const Reading& reading = (*frame)->readings[sensor];
    if (reading.sequence == last || reading.sequence == 0) continue;
    last = reading.sequence;
    const SensorModel& camera = (*frame)->model->sensors[sensor];
    Result<> done;
    if (reading.picture) {
      done = save(source, *reading.picture, camera.name, reading.sequence);
    } else if (reading.valid) {
      const auto then = source.recording.frame(source.recording.index_at(reading.time));
      if (!then) return tl::unexpected(then.error());
      const auto request = camera_request(*(*then)->model, camera, (*then)->state);
      if (!request) return tl::unexpected(request.error());
      const auto picture = rendered(source, **then, *request);
      if (!picture) return tl::unexpected(picture.error());
      done = save(source, *picture, camera.name, reading.sequence);
    }
    if (!done) return done;
  }
  return {};
}

// The scene from a viewpoint that was not in the run.
Result<> view_pictures(PictureSource& source, const std::string& name, const Frame& start) {
  const ViewModel* saved = nullptr;
  for (const ViewModel& view : start.model->views) {
    if (view.name == name) saved = &view;
  }
  Framing framing(start);
  const RecordingInfo& info = source.recording.info();
  const double begin = source.options.at.value_or(info.start);
  const double end = source.options.at.value_or(info.end);
  if (auto bearable = check_picture_count(end - begin, source.options.every); !bearable) {
    return bearable;
  }
  const auto count = static_cast<std::size_t>((end - begin) / source.options.every + 1e-6) + 1;
  for (std::size_t i = 0; i < count && !interrupted(); ++i) {
    const double time = begin + static_cast<double>(i) * source.options.every;
    const auto frame = source.recording.frame(source.recording.index_at(time));
    if (!frame) return tl::unexpected(frame.error());
    RenderRequest request;
    request.camera =
        saved == nullptr
            ? standard_camera(*standard_view(name), framing.follow(**frame), kViewWidth,
                              kViewHeight)
            : make_camera(view_pose(**frame, *saved), kViewWidth, kViewHeight, saved->fov);
    request.illustrated = true;
    const auto picture = rendered(source, **frame, request);
    if (!picture) return tl::unexpected(picture.error());
    if (auto done = save(source, *picture, name, i + 1); !done) return done;
  }
  return {};
}

Result<> render(PictureSource& source) {
  std::error_code error;
  std::filesystem::create_directories(source.options.output, error);
  if (error) {
    return fail(fmt::format("cannot write pictures into '{}': {}", source.options.output,
                            error.message()));
  }
  // The last frame's scene has all that ever was there.
  const auto start = source.recording.frame(0);
  const auto last = source.recording.frame(source.recording.frame_count() - 1);
  if (!start || !last) return tl::unexpected((!start ? start : last).error());
  const SceneModel& model = *(*last)->model;
  for (const std::string& name : source.options.render) {
    std::vector<std::string> known;
    std::optional<std::size_t> camera;
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
      if (model.sensors[i].type != "camera") continue;
      known.push_back(model.sensors[i].name);
      if (model.sensors[i].name == name) camera = i;
    }
    for (const ViewModel& view : model.views) known.push_back(view.name);
    for (const std::string& view : standard_view_names()) known.push_back(view);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      std::string list;
      for (const std::string& other : known) list += (list.empty() ? "" : ", ") + other;
      const std::string near = nearest_name(name, known);
      return fail(
          fmt::format("there is no camera or view '{}'", name), "",
          (near.empty() ? "" : fmt::format("did you mean '{}'? ", near)) + "there are " + list);
    }
    auto done = camera ? camera_pictures(source, *camera) : view_pictures(source, name, **start);
    if (!done) return done;
  }
  std::fputs(
      fmt::format("{} pictures in {}\n", source.pictures, one_line(source.options.output)).c_str(),
      stderr);
  return {};
}

// ---- numbers

// Gives every frame that is asked for to `visit`, with the readings asked for.
Result<> each_frame(Recording& recording, const ReplayOptions& options, PluginLoader& loader,
                    const std::function<void(const Frame&)>& visit) {
  if (options.recompute) {
    const std::size_t wanted = options.at ? recording.index_at(*options.at) : 0;
    std::size_t index = 0;
    return recording.recompute(loader, [&](const Frame& frame) {
      if (!options.at || index == wanted) visit(frame);
      ++index;
      return !interrupted();
    });
  }
  const std::size_t first = options.at ? recording.index_at(*options.at) : 0;
  const std::size_t end = options.at ? first + 1 : recording.frame_count();
  for (std::size_t i = first; i < end && !interrupted(); ++i) {
    const auto frame = recording.frame(i);
    if (!frame) return tl::unexpected(frame.error());
    visit(**frame);
  }
  return {};
}

void print_ros2(const std::string& file, const Ros2Writer::Summary& summary) {
  std::uint64_t messages = 0;
  for (const auto& [topic, count] : summary.messages) messages += count;
  std::fputs(fmt::format("{} messages on {} topics in {}\n", messages, summary.messages.size(),
                         one_line(file))
                 .c_str(),
             stderr);
  for (const std::string& what : summary.left_out)
    print_warning(fmt::format("{} has no message here: left out", what));
}

Result<> numbers(Recording& recording, const ReplayOptions& options, PluginLoader& loader) {
  const ChannelsOf channels = [&](int sensor) -> const std::vector<Channel>& {
    return recording.channels(sensor);
  };
  std::optional<JsonLines> lines;
  if (!options.json.empty()) {
    auto created = JsonLines::create(options.json);
    if (!created) return tl::unexpected(created.error());
    lines.emplace(std::move(*created));
  }
  std::unique_ptr<ReplayTables> tables;
  if (!options.csv.empty()) {
    auto created = ReplayTables::create(options.csv);
    if (!created) return tl::unexpected(created.error());
    tables = std::move(*created);
  }
  std::unique_ptr<Ros2Writer> ros2;
  if (!options.ros2.empty()) {
    auto created = Ros2Writer::create(options.ros2, output_rules());
    if (!created) return tl::unexpected(created.error());
    ros2 = std::move(*created);
  }
  Result<> written;
  auto done = each_frame(recording, options, loader, [&](const Frame& frame) {
    if (ros2 && written) written = ros2->add(frame);
    if (lines) lines->add(frame_json(frame, channels));
    if (tables) tables->add(frame, channels);
  });
  // Part of a run would pass for all of it.
  if (interrupted()) return nothing_written();
  if (done && lines) done = lines->finish();
  if (done && tables) done = tables->finish();
  if (done) done = written;
  if (done && ros2) {
    const auto summary = ros2->finish();
    if (!summary) return tl::unexpected(summary.error());
    print_ros2(options.ros2, *summary);
  }
  return done;
}

}  // namespace

int replay_command(const ReplayOptions& options) {
  catch_interrupts();
  add_input(options.file);
  const auto opened = Recording::open(options.file);
  if (!opened) {
    return refuse(opened.error());
  }
  Recording& recording = **opened;
  if (const std::string& damage = recording.info().damage; !damage.empty()) {
    print_warning(fmt::format("{}: {}; using what is readable, up to {}", options.file,
                              damage, time_text(recording.info().end)));
  }
  PluginLoader loader(options.plugin_paths);
  Result<> done;
  if (!options.json.empty() || !options.csv.empty() || !options.ros2.empty())
    done = numbers(recording, options, loader);
  if (done && !options.render.empty()) {
    PictureSource source{options, recording, loader, nullptr, 0};
    done = render(source);
  }
  int status = kGood;
  if (done && options.verify) {
    Verification verification(recording);
    done = recording.recompute(loader, [&](const Frame& frame) {
      verification.compare(frame);
      return !interrupted();
    });
    if (interrupted()) done = fail("interrupted: the readings are not verified");
    if (done) status = verification.report();
  }
  if (!done) {
    return refuse(done.error());
  }
  return status;
}

}  // namespace cogrsim::cli
