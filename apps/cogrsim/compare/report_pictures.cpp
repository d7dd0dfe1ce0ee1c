#include "compare/report_pictures.h"

#include <fmt/format.h>

#include "cogrsim/rendering/standard_view.h"
#include "compare/lockstep.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

constexpr int kReportWidth = 640, kReportHeight = 480;  // [pixel]

Result<PictureInstant> instant(const std::string& title, const std::vector<FramePtr>& frames,
                             const std::vector<RunEnd>& runs, Renderer& renderer) {
  geometry::Bounds bounds;
  for (const FramePtr& frame : frames) bounds.add(visible_bounds(*frame));
  PictureInstant out;
  out.title = title;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    RenderRequest request;
    request.camera = standard_camera(StandardView::iso, bounds, kReportWidth, kReportHeight);
    request.illustrated = true;
    auto pictures = renderer.render(*frames[i], {request});
    if (!pictures) return tl::unexpected(pictures.error());
    auto png = encode_png(pictures->front().color);
    if (!png) return tl::unexpected(png.error());
    out.pictures.emplace_back(runs[i].label, std::move(*png));
  }
  return out;
}

// The first run's end in colour, what moves in the others as outlines in the colour of their
// trails.
Result<std::string> overlaid_map(const LockstepResult& result) {
  static constexpr Color kColors[] = {
      {0.12, 0.44, 0.72, 1}, {0.81, 0.31, 0.05, 1}, {0.04, 0.54, 0.37, 1}, {0.65, 0.24, 0.56, 1}};
  MapOptions options;
  options.width = 960;
  MapArea area = map_area(*result.last.front());
  for (std::size_t i = 0; i < result.last.size(); ++i) {
    const Color& color = kColors[i % std::size(kColors)];
    bool first = true;
    for (MapTrail trail : result.trails[i]) {
      trail.label = first ? result.runs[i].label : "";
      trail.color = color;
      first = false;
      options.trails.push_back(std::move(trail));
    }
    if (i > 0) options.ghosts.push_back({result.last[i], color});
    area = joined(area, map_area(*result.last[i], result.trails[i]));
  }
  options.area = area;
  return map_picture(*result.last.front(), options, ".svg");
}

}  // namespace

ReportPictures report_pictures(const LockstepResult& result, PluginLoader& loader) {
  ReportPictures out;
  if (result.last.empty()) return out;
  auto map = overlaid_map(result);
  if (map) {
    out.map = std::move(*map);
  } else {
    out.problem = map.error().text();
  }
  auto renderer = load_renderer(loader);
  if (!renderer) {
    out.problem = renderer.error().message;
    return out;
  }
  const auto add = [&](const std::string& title, const std::vector<FramePtr>& frames) {
    if (frames.empty() || !out.problem.empty()) return;
    auto made = instant(title, frames, result.runs, **renderer);
    if (made) {
      out.instants.push_back(std::move(*made));
    } else {
      out.problem = made.error().message;
    }
  };
  if (!result.divergence.empty()) {
    add(fmt::format("Divergence at {}: {}", time_text(result.divergence.front()->time),
                    result.comparison.first_over_name),
        result.divergence);
  }
  add(fmt::format("The end, at {}", time_text(result.last.front()->time)), result.last);
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63u];
    }
  }
  return out;
}

}  // namespace cogrsim::cli
