// cogrsim map: the plan view of a scene or a recording.
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "cogrsim/map/map.h"
#include "render/film.h"
#include "render/frames.h"
#include "common/options.h"
#include "common/output_file.h"
#include "render/picture_file.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "render/trails.h"

namespace cogrsim::cli {
namespace {

// Trails are drawn through this many points at most.
constexpr double kMapTrailPoints = 2000.0;

struct Job {
  const MapCommandOptions& options;
  FrameSource& source;
  MapOptions drawing;
};

std::string title_of(const FrameSource& source, double time) {
  return fmt::format("{}  {}  t = {}", source.name(), source.backend(), time_text(time));
}

int draw_one(Job& job) {
  const double at = job.options.at ? *job.options.at : job.source.end();
  Result<FramePtr> frame = job.source.at(0.0);
  if (!frame) return refuse(frame.error());
  auto trails = Trails::of(*(*frame)->model, job.options.trails);
  if (!trails) return refuse(trails.error());
  trails->add(**frame);
  const double every = std::max(at / kMapTrailPoints, (*frame)->model->physics.step);
  const double start = (*frame)->time;
  for (double k = 1.0; start + k * every < at; ++k) {
    frame = job.source.at(start + k * every);
    if (!frame) return refuse(frame.error());
    trails->add(**frame);
  }
  frame = job.source.at(at);
  if (!frame) return refuse(frame.error());
  trails->add(**frame);
  job.drawing.trails = trails->trails();
  job.drawing.title = title_of(job.source, (*frame)->time);
  if (job.options.rays) job.drawing.rays = sensor_rays(**frame);
  if (auto done = draw_map(**frame, job.drawing, job.options.output, output_rules()); !done) {
    return refuse(done.error());
  }
  return kGood;
}

int draw_film(Job& job) {
  const double end = job.options.at ? *job.options.at : job.source.end();
  const double every = job.options.every;
  Result<FramePtr> first = job.source.at(0.0);
  if (!first) return refuse(first.error());
  auto trails = Trails::of(*(*first)->model, job.options.trails);
  if (!trails) return refuse(trails.error());
  if (auto bearable = check_picture_count(end - (*first)->time, every); !bearable) {
    return refuse(bearable.error());
  }
  // The area must hold the whole run, so all frames are gathered before the first is drawn.
  std::vector<FramePtr> frames;
  for (double k = 0.0; k * every <= end + 1e-9; ++k) {
    Result<FramePtr> frame = job.source.at((*first)->time + k * every);
    if (!frame) return refuse(frame.error());
    frames.push_back(*frame);
  }
  if (!job.drawing.area) {
    MapArea area = map_area(*frames.front());
    for (const FramePtr& frame : frames) area = joined(area, map_area(*frame));
    job.drawing.area = area;
  }
  auto film = Film::start(job.options.output, job.options.speed / every);
  if (!film) return refuse(film.error());
  for (const FramePtr& frame : frames) {
    trails->add(*frame);
    job.drawing.trails = trails->trails();
    job.drawing.title = title_of(job.source, frame->time);
    if (job.options.rays) job.drawing.rays = sensor_rays(*frame);
    const Result<std::string> png = map_picture(*frame, job.drawing, ".png");
    if (!png) return refuse(png.error());
    if (auto added = (*film)->add(*png); !added) return refuse(added.error());
  }
  if (auto done = (*film)->finish(); !done) return refuse(done.error());
  return kGood;
}

}  // namespace

int map_command(const MapCommandOptions& options) {
  const bool film = is_film(options.output);
  if (auto fits = check_every(options.output, options.every, "0.1"); !fits) {
    print_error(fits.error().text());
    return kWrongUsage;
  }
  add_input(options.source.source.scene);
  if (auto writable = check_writable(options.output, kind_of_picture(options.output)); !writable)
    return refuse(writable.error());
  int status = kGood;
  const auto source = FrameSource::open(options.source, status);
  if (!source) return status;
  Job job{options, *source, {}};
  job.drawing.width = options.width;
  job.drawing.area = options.area;
  job.drawing.names = options.names;
  status = film ? draw_film(job) : draw_one(job);
  if (status == kGood) std::fprintf(stderr, "%s\n", one_line(options.output).c_str());
  return status;
}

}  // namespace cogrsim::cli
