// A cairo surface with world coordinates.
#pragma once

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>

#include <memory>
#include <string>

#include "cogrsim/map/map.h"

namespace cogrsim::map_detail {

struct Destroy {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};

/// A drawing of `width` by height() pixels, with world x to the right and y up.
class Canvas {
 public:
  /// `bytes` receives the file in finish(). Errors: those of cairo.
  static Result<Canvas> make(const std::string& ending, const MapArea& area, int width, int header,
                             std::string& bytes);

  cairo_t* context() const { return context_.get(); }
  double scale() const { return scale_; }  ///< [pixel/m]
  double width() const { return width_; }
  double height() const { return height_; }
  double header() const { return header_; }
  const MapArea& area() const { return area_; }

  double column(double x) const { return (x - area_.x_min) * scale_; }
  double row(double y) const { return header_ + (area_.y_max - y) * scale_; }

  void paint(const Color& color) const;  ///< sets the source
  void path(const std::vector<Eigen::Vector2d>& polygon) const;
  Result<> finish(const std::string& ending, std::string& bytes);

 private:
  std::unique_ptr<cairo_surface_t, Destroy> surface_;
  std::unique_ptr<cairo_t, Destroy> context_;
  MapArea area_;
  double scale_ = 1.0, width_ = 0.0, height_ = 0.0, header_ = 0.0;
};

}  // namespace cogrsim::map_detail
