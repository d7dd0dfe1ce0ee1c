#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>

#include "lens.h"
#include "overlay.h"

namespace cogrsim::osmesa {

namespace {

// A label stands on what it names, whose depth at the pixel's middle may be a little less.
constexpr double kNearer = 0.01;  // share of the distance

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

/// Where a point is seen [pixel]; false: behind the camera, out of the picture, or hidden.
bool find_pixel(const Vec3& at, const Camera& camera, const std::vector<float>& depth,
                Eigen::Vector2d& pixel) {
  if (!at.allFinite()) return false;
  const Vec3 p = camera.X_WC.inverse() * at;
  if (p.x() < camera.near || p.x() > camera.far) return false;
  pixel = distort(camera, {-p.y() / p.x(), -p.z() / p.x()});
  pixel = {camera.cx + camera.fx * pixel.x(), camera.cy + camera.fy * pixel.y()};
  if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < camera.width &&
        pixel.y() < camera.height)) {
    return false;
  }
  const auto index = static_cast<std::size_t>(pixel.y()) * static_cast<std::size_t>(camera.width) +
                     static_cast<std::size_t>(pixel.x());
  return (1.0 - kNearer) * p.x() <= static_cast<double>(depth[index]);
}

void write_text(cairo_t* context, const OverlayLabel& label, const Eigen::Vector2d& pixel,
                double size) {
  cairo_new_path(context);
  cairo_move_to(context, pixel.x() + 0.4 * size, pixel.y() + 0.35 * size);
  cairo_text_path(context, valid_utf8(label.text).c_str());
  // A rim that stands out from the letters keeps them readable on any ground.
  const double light = 0.3 * label.color.r + 0.59 * label.color.g + 0.11 * label.color.b;
  const double rim = light > 0.4 ? 0.0 : 1.0;
  cairo_set_source_rgba(context, rim, rim, rim, 0.6 * label.color.a);
  cairo_set_line_width(context, 0.18 * size);
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  cairo_stroke_preserve(context);
  cairo_set_source_rgba(context, label.color.r, label.color.g, label.color.b, label.color.a);
  cairo_fill(context);
}

}  // namespace

std::string valid_utf8(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) {
      return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0U;
    };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80 ? 1 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    unsigned code = length == 1 ? first : first & (0x7FU >> length);
    bool good = length == 1 || (first >= 0xC2 && first <= 0xF4);
    for (std::size_t k = 1; k < length && good; ++k) {
      good = (byte(k) & 0xC0U) == 0x80U;
      code = (code << 6U) | (byte(k) & 0x3FU);
    }
    good = good && (length < 3 || code >= (length == 3 ? 0x800U : 0x10000U)) && code <= 0x10FFFFU &&
           (code < 0xD800U || code > 0xDFFFU) && code != 0;
    out += good ? text.substr(i, length) : "\xEF\xBF\xBD";
    i += good ? length : 1;
  }
  return out;
}

void write_labels(const std::vector<OverlayLabel>& labels, const Camera& camera,
                  const std::vector<float>& depth, Image& picture) {
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture.width, picture.height),
      cairo_surface_destroy);
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  // Cairo's pixels are words of 32 bits, 0x00RRGGBB.
  unsigned char* const data = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  const auto word = [&](int column, int row) {
    return reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(row) * stride) +
           column;
  };
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      const std::uint8_t* p = picture.pixel(column, row);
      *word(column, row) = (std::uint32_t{p[0]} << 16U) | (std::uint32_t{p[1]} << 8U) | p[2];
    }
  }
  cairo_surface_mark_dirty(surface.get());
  const Context context(cairo_create(surface.get()), cairo_destroy);
  const double size = std::max(10.0, picture.height / 32.0);
  cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context.get(), size);
  for (const OverlayLabel& label : labels) {
    Eigen::Vector2d pixel;
    if (find_pixel(label.at, camera, depth, pixel)) write_text(context.get(), label, pixel, size);
  }
  cairo_surface_flush(surface.get());
  std::uint8_t* out = picture.data.data();
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column, out += 3) {
      const std::uint32_t value = *word(column, row);
      out[0] = static_cast<std::uint8_t>(value >> 16U);
      out[1] = static_cast<std::uint8_t>(value >> 8U);
      out[2] = static_cast<std::uint8_t>(value);
    }
  }
}

}  // namespace cogrsim::osmesa
