#include "render/picture_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

// Hues a golden angle apart, so that consecutive bodies have different hues; never black.
std::array<std::uint8_t, 3> body_color(int body) {
  const double hue = std::fmod(0.137 + 0.61803398875 * body, 1.0) * 6.0;
  const double strong = body % 2 == 0 ? 0.95 : 0.7, weak = strong * (body % 3 == 0 ? 0.15 : 0.4);
  const auto channel = [&](double shift) {
    const double k = std::fmod(hue + shift, 6.0);
    const double share = std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(255.0 * (strong - (strong - weak) * share)));
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

}  // namespace

Result<std::string> depth_png(const Picture& picture) {
  std::vector<std::uint16_t> millimetres(picture.depth.size(), 0);
  for (std::size_t i = 0; i < millimetres.size(); ++i) {
    const double d = picture.depth[i];
    if (std::isfinite(d)) {
      millimetres[i] = static_cast<std::uint16_t>(std::clamp(std::round(1e3 * d), 1.0, 65535.0));
    }
  }
  return encode_png16(picture.width, picture.height, millimetres);
}

Result<std::string> segmentation_png(const Picture& picture) {
  Image image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = 3;
  image.data.assign(3 * picture.bodies.size(), 0);
  for (std::size_t i = 0; i < picture.bodies.size(); ++i) {
    if (picture.bodies[i] < 0) continue;
    const auto color = body_color(picture.bodies[i]);
    std::copy(color.begin(), color.end(), image.data.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return encode_png(image);
}

std::string segmentation_legend(const SceneModel& model, const Picture& picture) {
  std::map<int, int> pixels;
  for (const std::int32_t body : picture.bodies) ++pixels[body];
  std::string text;
  for (const auto& [body, count] : pixels) {
    const auto color = body >= 0 ? body_color(body) : std::array<std::uint8_t, 3>{0, 0, 0};
    text +=
        fmt::format("#{:02x}{:02x}{:02x}  {:>8} pixels  {}\n", color[0], color[1], color[2], count,
                    body >= 0 ? one_line(model.bodies[body].name) : std::string("(background)"));
  }
  return text;
}

bool has_ending(const std::string& name, std::initializer_list<const char*> endings) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(endings.begin(), endings.end(), [&](const char* e) { return ending == e; });
}

OutputKind kind_of_picture(const std::string& name) {
  if (has_ending(name, {".gif", ".mp4", ".webm"})) return OutputKind::film;
  if (has_ending(name, {".jpg", ".jpeg"})) return OutputKind::jpeg;
  if (has_ending(name, {".svg"})) return OutputKind::svg;
  if (has_ending(name, {".pdf"})) return OutputKind::pdf;
  return OutputKind::png;
}

}  // namespace cogrsim::cli
