// cogrsim render: a picture of a scene or a recording.
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/rendering/framing.h"
#include "cogrsim/rendering/standard_view.h"
#include "cogrsim/sensing/sensor_models.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "render/film.h"
#include "render/frames.h"
#include "render/overlays.h"
#include "render/picture_file.h"
#include "render/trails.h"

namespace cogrsim::cli {
namespace {

constexpr double kTrailStep = 0.02;  // between points of a trail [s]

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

// The camera sensor's own picture, at its own resolution unless set otherwise.
Result<RenderRequest> through_camera(const Frame& frame, const RenderCommandOptions& options) {
  const SceneModel& model = *frame.model;
  std::vector<std::string> names;
  for (const SensorModel& sensor : model.sensors) {
    if (sensor.type != "camera" || sensor.removed) continue;
    names.push_back(sensor.name);
    if (sensor.name != options.camera) continue;
    auto request = camera_request(model, sensor, frame.state);
    if (request && options.width > 0) {
      Camera& c = request->camera;
      const double sx = static_cast<double>(options.width) / c.width;
      const double sy = static_cast<double>(options.height) / c.height;
      c.fx *= sx;
      c.cx *= sx;
      c.fy *= sy;
      c.cy *= sy;
      c.width = options.width;
      c.height = options.height;
    }
    return request;
  }
  const std::string near = nearest_name(options.camera, names);
  return fail(
      fmt::format("there is no camera '{}'", options.camera), "",
      fmt::format("{}the scene's cameras: {}; --view shows the scene without one",
                  near.empty() ? "" : fmt::format("did you mean '{}'? ", near), listed(names)));
}

Result<RenderRequest> from_view(const Frame& frame, const geometry::Bounds& bounds,
                                const RenderCommandOptions& options) {
  const int width = options.width > 0 ? options.width : kViewWidth;
  const int height = options.height > 0 ? options.height : kViewHeight;
  RenderRequest request;
  request.illustrated = true;
  std::vector<std::string> names;
  for (const ViewModel& view : frame.model->views) {
    names.push_back(view.name);
    if (view.name != options.view) continue;
    request.camera = make_camera(view_pose(frame, view), width, height, view.fov);
    return request;
  }
  const std::string wanted = options.view.empty() ? "iso" : options.view;
  if (const auto view = standard_view(wanted)) {
    request.camera = standard_camera(*view, bounds, width, height);
    return request;
  }
  for (const std::string& known : standard_view_names()) names.push_back(known);
  const std::string near = nearest_name(wanted, names);
  return fail(
      fmt::format("there is no view '{}'", wanted), "",
      fmt::format("{}there are {}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                  listed(names)));
}

struct Studio {
  const RenderCommandOptions& options;
  OverlayChoice overlays;
  FrameSource& source;
  std::shared_ptr<Renderer> renderer;
  geometry::Bounds bounds;
  std::vector<MapTrail> trails;
};

Result<Picture> shoot(Studio& studio, const Frame& frame) {
  const RenderCommandOptions& options = studio.options;
  auto request = options.camera.empty() ? from_view(frame, studio.bounds, options)
                                        : through_camera(frame, options);
  if (!request) return tl::unexpected(request.error());
  request->depth = options.depth;
  request->segmentation = options.segmentation;
  request->color = !options.depth && !options.segmentation;
  request->shadows = options.shadows;
  const double size = (studio.bounds.high - studio.bounds.low).norm();
  request->overlay = make_overlay(frame, studio.overlays, size, studio.trails);
  auto pictures = studio.renderer->render(frame, {*request});
  if (!pictures) return tl::unexpected(pictures.error());
  return std::move(pictures->front());
}

Result<std::string> file_of(const Studio& studio, const Picture& picture) {
  if (studio.options.depth) return depth_png(picture);
  if (studio.options.segmentation) return segmentation_png(picture);
  const std::string& name = studio.options.output;
  if (has_ending(name, {".jpg", ".jpeg"})) return encode_jpeg(picture.color);
  return encode_png(picture.color);
}

int one_picture(Studio& studio) {
  const double at = studio.options.at ? *studio.options.at : studio.source.end();
  Result<FramePtr> frame = studio.source.at(0.0);
  if (!frame) return refuse(frame.error());
  const Framing framing(**frame);
  if (studio.overlays.trails) {
    auto trails = Trails::of(*(*frame)->model, {});
    if (!trails) return refuse(trails.error());
    const double every = std::max(kTrailStep, at / 5000.0);
    for (double t = (*frame)->time; t < at; t += every) {
      frame = studio.source.at(t);
      if (!frame) return refuse(frame.error());
      trails->add(**frame);
    }
    studio.trails = trails->trails();
  }
  frame = studio.source.at(at);
  if (!frame) return refuse(frame.error());
  studio.bounds = framing.single(**frame);
  auto picture = shoot(studio, **frame);
  if (!picture) return refuse(picture.error());
  auto bytes = file_of(studio, *picture);
  if (!bytes) return refuse(bytes.error());
  if (auto done =
          write_output(studio.options.output, kind_of_picture(studio.options.output), *bytes);
      !done) {
    return refuse(done.error());
  }
  if (studio.options.segmentation) {
    const auto printed = print_report(segmentation_legend(*(*frame)->model, *picture));
    if (!printed) return refuse(printed.error());
  }
  return kGood;
}

int film(Studio& studio) {
  const RenderCommandOptions& options = studio.options;
  const double end = options.at ? *options.at : studio.source.end();
  Result<FramePtr> frame = studio.source.at(0.0);
  if (!frame) return refuse(frame.error());
  const double start = (*frame)->time;
  if (auto bearable = check_picture_count(end - start, options.every); !bearable) {
    return refuse(bearable.error());
  }
  Framing framing(**frame);
  auto film = Film::start(options.output, options.speed / options.every);
  if (!film) return refuse(film.error());
  auto trails = Trails::of(*(*frame)->model, {});
  if (!trails) return refuse(trails.error());
  for (double k = 0.0; start + k * options.every <= end + 1e-9; ++k) {
    frame = studio.source.at(start + k * options.every);
    if (!frame) return refuse(frame.error());
    trails->add(**frame);
    studio.bounds = framing.follow(**frame);
    if (studio.overlays.trails) studio.trails = trails->trails();
    auto picture = shoot(studio, **frame);
    if (!picture) return refuse(picture.error());
    auto bytes = file_of(studio, *picture);
    if (!bytes) return refuse(bytes.error());
    if (auto added = (*film)->add(*bytes); !added) return refuse(added.error());
  }
  if (auto done = (*film)->finish(); !done) return refuse(done.error());
  return kGood;
}

}  // namespace

int render_command(const RenderCommandOptions& options) {
  const bool moving = is_film(options.output);
  const auto misuse = [](const std::string& text) {
    print_error(text);
    return kWrongUsage;
  };
  if (!options.camera.empty() && !options.view.empty()) {
    return misuse("--camera and --view are both given\nhelp: a picture has one viewpoint");
  }
  if (options.depth && options.segmentation) {
    return misuse("--depth and --segmentation are both given\nhelp: make two pictures");
  }
  if (auto fits = check_every(options.output, options.every, "0.05"); !fits) {
    return misuse(fits.error().text());
  }
  if (!moving && !has_ending(options.output, {".png", ".jpg", ".jpeg"})) {
    return misuse(
        fmt::format("'{}' is not a name for a picture\nhelp: end it with .png or .jpg, or "
                    "with .gif, .mp4 or .webm for a film",
                    options.output));
  }
  if ((options.depth || options.segmentation) && !moving && !has_ending(options.output, {".png"})) {
    return misuse("depth and segmentation are kept as PNG only\nhelp: end the name with .png");
  }
  auto overlays = parse_overlays(options.overlays);
  if (!overlays) return misuse(overlays.error().text());
  add_input(options.source.source.scene);
  if (auto writable = check_writable(options.output, kind_of_picture(options.output)); !writable)
    return refuse(writable.error());

  int status = kGood;
  const auto source = FrameSource::open(options.source, status);
  if (!source) return status;
  auto renderer = load_renderer(source->loader());
  if (!renderer) return refuse(renderer.error());
  Studio studio{options, *overlays, *source, std::move(*renderer), {}, {}};
  status = moving ? film(studio) : one_picture(studio);
  if (status == kGood) std::fprintf(stderr, "%s\n", one_line(options.output).c_str());
  return status;
}

}  // namespace cogrsim::cli
