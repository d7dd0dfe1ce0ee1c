#include "map/canvas.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::map_detail {

namespace {

// Narrow areas are widened to this aspect ratio, so that every drawing is readable.
constexpr double kMostStretched = 4.0;
// Cairo measures vector drawings in points of 1/72 inch; one pixel is one point here.

cairo_status_t append(void* closure, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Result<Canvas> Canvas::make(const std::string& ending, const MapArea& area, int width, int header,
                            std::string& bytes) {
  Canvas canvas;
  canvas.area_ = area;
  MapArea& a = canvas.area_;
  const double wide = a.x_max - a.x_min, high = a.y_max - a.y_min;
  const double more_high = std::max(0.0, wide / kMostStretched - high) / 2.0;
  const double more_wide = std::max(0.0, high / kMostStretched - wide) / 2.0;
  a.y_min -= more_high;
  a.y_max += more_high;
  a.x_min -= more_wide;
  a.x_max += more_wide;

  canvas.width_ = width;
  canvas.header_ = header;
  canvas.scale_ = canvas.width_ / (a.x_max - a.x_min);
  // Even numbers of pixels, as video encoders require.
  canvas.height_ = 2.0 * std::ceil(((a.y_max - a.y_min) * canvas.scale_ + header) / 2.0);
  a.y_min = a.y_max - (canvas.height_ - header) / canvas.scale_;

  cairo_surface_t* surface = nullptr;
  if (ending == ".svg") {
    surface = cairo_svg_surface_create_for_stream(append, &bytes, canvas.width_, canvas.height_);
    cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_PX);
  } else if (ending == ".pdf") {
    surface = cairo_pdf_surface_create_for_stream(append, &bytes, canvas.width_, canvas.height_);
  } else {
    surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width,
                                         static_cast<int>(std::lround(canvas.height_)));
  }
  canvas.surface_.reset(surface);
  canvas.context_.reset(cairo_create(surface));
  if (const cairo_status_t status = cairo_status(canvas.context_.get())) {
    return fail(std::string("the map cannot be drawn: ") + cairo_status_to_string(status));
  }
  return canvas;
}

void Canvas::paint(const Color& color) const {
  cairo_set_source_rgba(context(), color.r, color.g, color.b, color.a);
}

void Canvas::path(const std::vector<Eigen::Vector2d>& polygon) const {
  bool first = true;
  for (const Eigen::Vector2d& p : polygon) {
    if (first) {
      cairo_move_to(context(), column(p.x()), row(p.y()));
    } else {
      cairo_line_to(context(), column(p.x()), row(p.y()));
    }
    first = false;
  }
  if (!first) cairo_close_path(context());
}

Result<> Canvas::finish(const std::string& ending, std::string& bytes) {
  cairo_status_t status = cairo_status(context());
  context_.reset();
  if (status == CAIRO_STATUS_SUCCESS && ending == ".png") {
    status = cairo_surface_write_to_png_stream(surface_.get(), append, &bytes);
  }
  cairo_surface_finish(surface_.get());
  if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_status(surface_.get());
  surface_.reset();
  if (status != CAIRO_STATUS_SUCCESS) {
    return fail(std::string("the map cannot be drawn: ") + cairo_status_to_string(status));
  }
  return {};
}

}  // namespace cogrsim::map_detail
