// Drawing of maps.
#include "cogrsim/map/map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "cogrsim/core/image.h"
#include "cogrsim/geometry/convex.h"
#include "cogrsim/model/surface.h"
#include "cogrsim/rendering/looks.h"
#include "map/canvas.h"

namespace cogrsim {

namespace {

using map_detail::Canvas;

constexpr Color kPaper{0.97, 0.97, 0.96, 1};
constexpr Color kInk{0.15, 0.15, 0.15, 1};
constexpr Color kRay{0.9, 0.05, 0.05, 0.8}, kFan{0.25, 0.5, 0.85, 0.22},
    kFanHit{0.1, 0.35, 0.75, 0.8};
constexpr double kTextSize = 12.0;  // [pixel]

MapArea nothing() {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  return {kInf, kInf, -kInf, -kInf};
}

void enclose(MapArea& area, double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y)) return;
  area.x_min = std::min(area.x_min, x);
  area.x_max = std::max(area.x_max, x);
  area.y_min = std::min(area.y_min, y);
  area.y_max = std::max(area.y_max, y);
}

void enclose_body(MapArea& area, const SceneModel& model, const Body& body, const Pose& X_WB) {
  for (const Shape& shape : body.shapes) {
    if (!shape.visible) continue;
    for (const auto& polygon : plan_outline(model, shape, X_WB)) {
      for (const auto& p : polygon) enclose(area, p.x(), p.y());
    }
  }
}

/// A shape to be drawn; shapes are sorted by height.
struct Item {
  const Shape* shape = nullptr;
  int body = -1;
  Pose X_WB;
  double top = 0.0;  ///< highest point [m]
  bool fixed = false;
};

// Height of the highest point of a shape.
double top_of(const SceneModel& model, const Shape& shape, const Pose& X_WS) {
  const Vec3 up = X_WS.q.conjugate() * Vec3::UnitZ();     // in the frame of the shape
  if (shape.type == ShapeType::plane) return -kInfinity;  // below everything
  if (shape.type == ShapeType::heightmap)  // the lowest: shapes on it must be visible
    return X_WS.p.z() + geometry::local_bounds(model, shape).low.z();
  return X_WS.p.z() + geometry::core_of(model, shape).extent(up);
}

std::vector<Item> items_of(const Frame& frame) {
  const SceneModel& model = *frame.model;
  std::vector<Item> items;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.removed) continue;
    for (const Shape& shape : body.shapes) {
      if (!shape.visible) continue;
      const Pose& X_WB = frame.state.poses[b];
      items.push_back({&shape, static_cast<int>(b), X_WB, top_of(model, shape, X_WB * shape.X_BS),
                       body.kind == BodyKind::static_body});
    }
  }
  std::stable_sort(items.begin(), items.end(),
                   [](const Item& a, const Item& b) { return a.top < b.top; });
  return items;
}

// The mean colour of a shape, including its texture.
Color far_color(const SceneModel& model, const Item& item, TextureStore& textures) {
  Color color = shown_color(model, item.body, *item.shape);
  const auto image = textures.texture(model.materials[item.shape->material]);
  if (!image) return color;
  constexpr int kSamples = 16;
  double r = 0, g = 0, b = 0;
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const Color c =
        sample(*image, Vec2((i % kSamples + 0.5) / kSamples, (i / kSamples + 0.5) / kSamples));
    r += c.r;
    g += c.g;
    b += c.b;
  }
  constexpr double kAll = kSamples * kSamples;
  color.r *= r / kAll;
  color.g *= g / kAll;
  color.b *= b / kAll;
  return color;
}

Color darker(const Color& c, double factor) {
  return {c.r * factor, c.g * factor, c.b * factor, c.a};
}

// A horizontal or sloped plane fills the map; a vertical one fills one half of it.
void draw_plane(const Canvas& canvas, const Pose& X_WS, const Color& color) {
  const MapArea& a = canvas.area();
  std::vector<Eigen::Vector2d> region = {
      {a.x_min, a.y_min}, {a.x_max, a.y_min}, {a.x_max, a.y_max}, {a.x_min, a.y_max}};
  const Vec3 normal = X_WS.q * Vec3::UnitZ();
  if (normal.z() < -0.5) return;  // a ceiling, which would hide the whole scene
  if (std::abs(normal.z()) < 1e-6) {
    // Clip the map against the line of the wall (one step of Sutherland and Hodgman).
    std::vector<Eigen::Vector2d> kept;
    const auto side = [&](const Eigen::Vector2d& p) {
      return normal.x() * (p.x() - X_WS.p.x()) + normal.y() * (p.y() - X_WS.p.y());
    };
    for (std::size_t i = 0; i < region.size(); ++i) {
      const Eigen::Vector2d &p = region[i], &q = region[(i + 1) % region.size()];
      const double sp = side(p), sq = side(q);
      if (sp <= 0.0) kept.push_back(p);
      if ((sp < 0.0 && sq > 0.0) || (sp > 0.0 && sq < 0.0)) {
        kept.push_back(p + (q - p) * (sp / (sp - sq)));
      }
    }
    region = std::move(kept);
  }
  canvas.paint(color);
  canvas.path(region);
  cairo_fill(canvas.context());
}

// Draws heights as brightness, in at most 64 x 64 patches.
void draw_heightmap(const Canvas& canvas, const SceneModel& model, const Shape& shape,
                    const Pose& X_WS, const Color& color) {
  const HeightGrid& grid = *model.heightmaps[shape.heightmap];
  const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
  const double span = std::max(*high - *low, 1e-12);
  const int columns = std::min(grid.columns - 1, 64), rows = std::min(grid.rows - 1, 64);
  cairo_set_antialias(canvas.context(), CAIRO_ANTIALIAS_NONE);  // avoids seams between patches
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int gc = (2 * c + 1) * (grid.columns - 1) / (2 * columns);
      const int gr = (2 * r + 1) * (grid.rows - 1) / (2 * rows);
      const double h = grid.heights[gr * grid.columns + gc];
      std::vector<Eigen::Vector2d> patch;
      for (const auto& [dc, dr] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        const Vec3 p = X_WS * Vec3(grid.size_x * ((c + dc) / static_cast<double>(columns) - 0.5),
                                   grid.size_y * ((r + dr) / static_cast<double>(rows) - 0.5), h);
        patch.emplace_back(p.x(), p.y());
      }
      canvas.paint(darker(color, 0.55 + 0.45 * (h - *low) / span));
      canvas.path(patch);
      cairo_fill(canvas.context());
    }
  }
  cairo_set_antialias(canvas.context(), CAIRO_ANTIALIAS_DEFAULT);
}

/// The area that a lidar has seen, at the height of its rays.
struct Fan {
  double height = 0.0;  ///< of the lidar [m]
  std::vector<Eigen::Vector2d> outline;
};

bool of_lidar(const SensorRay& ray, const SceneModel& model) {
  return ray.sensor >= 0 && model.sensors[ray.sensor].type == "lidar";
}

// The lowest first.
std::vector<Fan> fans_of(const SceneModel& model, const std::vector<SensorRay>& rays) {
  std::map<int, Fan> fans;
  for (const SensorRay& ray : rays) {
    if (!of_lidar(ray, model) || !ray.from.allFinite() || !ray.to.allFinite()) continue;
    Fan& fan = fans[ray.sensor];
    if (fan.outline.empty()) fan.outline.push_back(ray.from.head<2>());
    fan.height = ray.from.z();
    fan.outline.push_back(ray.to.head<2>());
  }
  std::vector<Fan> sorted;
  for (auto& [sensor, fan] : fans) {
    // The last ray of a full turn is beside the first one; otherwise the lidar is a corner.
    std::vector<Eigen::Vector2d>& outline = fan.outline;
    const auto bearing = [&](std::size_t i) {
      return std::atan2(outline[i].y() - outline[0].y(), outline[i].x() - outline[0].x());
    };
    const auto between = [&](std::size_t i, std::size_t j) {
      return std::abs(std::remainder(bearing(j) - bearing(i), 2.0 * kPi));
    };
    if (outline.size() > 3 && between(outline.size() - 1, 1) < 1.5 * between(1, 2))
      outline.erase(outline.begin());
    sorted.push_back(std::move(fan));
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Fan& a, const Fan& b) { return a.height < b.height; });
  return sorted;
}

// Shapes that are higher than a lidar hide its fan: it lies over no wall that its rays met.
void draw_shapes(const Canvas& canvas, const Frame& frame, const std::vector<SensorRay>& rays) {
  const SceneModel& model = *frame.model;
  cairo_t* cr = canvas.context();
  TextureStore textures;
  const std::vector<Fan> fans = fans_of(model, rays);
  auto fan = fans.begin();
  const auto draw_fans_below = [&](double height) {
    for (; fan != fans.end() && fan->height < height; ++fan) {
      canvas.paint(kFan);
      cairo_new_path(cr);
      canvas.path(fan->outline);
      cairo_fill(cr);
    }
  };
  for (const Item& item : items_of(frame)) {
    draw_fans_below(item.top);
    const Shape& shape = *item.shape;
    const Pose X_WS = item.X_WB * shape.X_BS;
    const Color color = far_color(model, item, textures);
    if (shape.type == ShapeType::plane) {
      draw_plane(canvas, X_WS, color);
      continue;
    }
    if (shape.type == ShapeType::heightmap) {
      draw_heightmap(canvas, model, shape, X_WS, color);
      continue;
    }
    cairo_new_path(cr);
    for (const auto& polygon : plan_outline(model, shape, item.X_WB)) canvas.path(polygon);
    canvas.paint(color);
    if (shape.type == ShapeType::mesh) {
      cairo_fill(cr);  // without edges, because those of all triangles would hide it
      continue;
    }
    cairo_fill_preserve(cr);
    canvas.paint(darker(color, 0.45));
    cairo_set_line_width(cr, 1.0);
    cairo_stroke(cr);
  }
  draw_fans_below(kInfinity);
}

void draw_ghosts(const Canvas& canvas, const std::vector<MapGhost>& ghosts) {
  cairo_t* cr = canvas.context();
  cairo_set_line_width(cr, 1.5);
  for (const MapGhost& ghost : ghosts) {
    const SceneModel& model = *ghost.frame->model;
    for (const Item& item : items_of(*ghost.frame)) {
      if (item.fixed || item.shape->type == ShapeType::mesh) continue;
      cairo_new_path(cr);
      for (const auto& polygon : plan_outline(model, *item.shape, item.X_WB)) canvas.path(polygon);
      canvas.paint(ghost.color);
      cairo_stroke(cr);
    }
  }
}

// The largest number of the form 1, 2 or 5 times a power of ten that is not above the value.
double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= length) return step * power;
  }
  return power;
}

void draw_grid(const Canvas& canvas) {
  cairo_t* cr = canvas.context();
  const MapArea& a = canvas.area();
  const double step = round_length((a.x_max - a.x_min) / 5.0);
  canvas.paint({0.2, 0.2, 0.3, 0.13});
  cairo_set_line_width(cr, 1.0);
  for (double x = std::ceil(a.x_min / step) * step; x <= a.x_max; x += step) {
    cairo_move_to(cr, canvas.column(x), canvas.row(a.y_max));
    cairo_line_to(cr, canvas.column(x), canvas.row(a.y_min));
  }
  for (double y = std::ceil(a.y_min / step) * step; y <= a.y_max; y += step) {
    cairo_move_to(cr, canvas.column(a.x_min), canvas.row(y));
    cairo_line_to(cr, canvas.column(a.x_max), canvas.row(y));
  }
  cairo_stroke(cr);
}

/// Dark text with a light outline, readable on any background.
void write(const Canvas& canvas, double column, double row, const std::string& text) {
  cairo_t* cr = canvas.context();
  cairo_move_to(cr, column, row);
  cairo_text_path(cr, text.c_str());
  canvas.paint({1, 1, 1, 0.85});
  cairo_set_line_width(cr, 3.0);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  cairo_stroke_preserve(cr);
  canvas.paint(kInk);
  cairo_fill(cr);
}

// Draws the names of top-level assemblies and of bodies without an assembly, larger ones first,
// where no other text is.
void draw_names(const Canvas& canvas, const Frame& frame) {
  const SceneModel& model = *frame.model;
  cairo_t* cr = canvas.context();
  struct Label {
    std::string text;
    MapArea area;
    bool moves = false;
  };
  std::vector<Label> labels;
  std::vector<int> of_assembly(model.assemblies.size(), -1);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.removed) continue;
    MapArea area = nothing();
    enclose_body(area, model, body, frame.state.poses[b]);
    if (!(area.x_min <= area.x_max)) continue;
    const bool moves = body.kind != BodyKind::static_body;
    const int assembly = top_level_assembly(model, body.assembly);
    if (assembly < 0) {
      labels.push_back({body.name, area, moves});
      continue;
    }
    int& index = of_assembly[assembly];
    if (index < 0) {
      index = static_cast<int>(labels.size());
      labels.push_back({model.assemblies[assembly].name, area, moves});
    } else {
      Label& label = labels[index];
      label.area = joined(label.area, area);
      label.moves = label.moves || moves;
    }
  }
  // Movable objects have priority over walls.
  std::stable_sort(labels.begin(), labels.end(),
                   [](const Label& a, const Label& b) { return a.moves && !b.moves; });
  std::vector<MapArea> taken;  // in pixels
  for (const Label& label : labels) {
    cairo_text_extents_t extents;
    cairo_text_extents(cr, label.text.c_str(), &extents);
    const double middle = canvas.column(0.5 * (label.area.x_min + label.area.x_max));
    const double left = std::clamp(middle - 0.5 * extents.width, 2.0,
                                   std::max(2.0, canvas.width() - extents.width - 2.0));
    const double above = canvas.row(label.area.y_max) - 5.0;
    const double centred = canvas.row(0.5 * (label.area.y_min + label.area.y_max)) + 4.0;
    const double below = canvas.row(label.area.y_min) + kTextSize + 2.0;
    for (const double baseline : {above, below, centred}) {
      const MapArea box = {left - 2, baseline - kTextSize, left + extents.width + 2, baseline + 3};
      if (box.y_min < canvas.header() || box.y_max > canvas.height()) continue;
      const bool free = std::none_of(taken.begin(), taken.end(), [&](const MapArea& other) {
        return box.x_min < other.x_max && other.x_min < box.x_max && box.y_min < other.y_max &&
               other.y_min < box.y_max;
      });
      if (!free) continue;
      taken.push_back(box);
      write(canvas, left, baseline, label.text);
      break;
    }
  }
}

void draw_trails(const Canvas& canvas, const std::vector<MapTrail>& trails) {
  cairo_t* cr = canvas.context();
  const double dashes[] = {7.0, 4.0};
  for (const MapTrail& trail : trails) {
    bool drawing = false;
    const Vec3* first = nullptr;
    for (const Vec3& p : trail.points) {
      if (!p.allFinite()) {
        drawing = false;
        continue;
      }
      if (first == nullptr) first = &p;
      if (drawing) {
        cairo_line_to(cr, canvas.column(p.x()), canvas.row(p.y()));
      } else {
        cairo_move_to(cr, canvas.column(p.x()), canvas.row(p.y()));
      }
      drawing = true;
    }
    cairo_set_dash(cr, dashes, 2, 0.0);
    cairo_set_line_width(cr, 1.8);
    canvas.paint(trail.color);
    cairo_stroke(cr);
    cairo_set_dash(cr, nullptr, 0, 0.0);
    if (first != nullptr) {  // a ring at the start
      cairo_arc(cr, canvas.column(first->x()), canvas.row(first->y()), 3.5, 0.0, 6.2831853);
      cairo_stroke(cr);
    }
  }
}

// What rays hit is a point; the rays of a lidar are its fan (draw_shapes), other rays are lines.
void draw_rays(const Canvas& canvas, const SceneModel& model, const std::vector<SensorRay>& rays) {
  cairo_t* cr = canvas.context();
  cairo_set_line_width(cr, 1.0);
  for (const SensorRay& ray : rays) {
    if (!ray.from.allFinite() || !ray.to.allFinite()) continue;
    const bool lidar = of_lidar(ray, model);
    canvas.paint(lidar ? kFanHit : kRay);
    if (!lidar) {
      cairo_move_to(cr, canvas.column(ray.from.x()), canvas.row(ray.from.y()));
      cairo_line_to(cr, canvas.column(ray.to.x()), canvas.row(ray.to.y()));
      cairo_stroke(cr);
    }
    if (!ray.hit) continue;
    cairo_arc(cr, canvas.column(ray.to.x()), canvas.row(ray.to.y()), lidar ? 1.2 : 2.0, 0.0,
              6.2831853);
    cairo_fill(cr);
  }
}

std::string length_text(double metres) {
  char text[32];
  if (metres >= 1.0) {
    std::snprintf(text, sizeof text, "%g m", metres);
  } else if (metres >= 0.01) {
    std::snprintf(text, sizeof text, "%g cm", std::round(metres * 1e6) / 1e4);
  } else {
    std::snprintf(text, sizeof text, "%g mm", std::round(metres * 1e9) / 1e6);
  }
  return text;
}

void draw_scale_bar(const Canvas& canvas) {
  cairo_t* cr = canvas.context();
  const MapArea& a = canvas.area();
  const double length = round_length((a.x_max - a.x_min) / 4.0);
  const double left = 14.0, row = canvas.height() - 14.0, pixels = length * canvas.scale();
  cairo_rectangle(cr, left - 8, row - 24, pixels + 16, 32);
  canvas.paint({1, 1, 1, 0.75});
  cairo_fill(cr);
  canvas.paint(kInk);
  cairo_set_line_width(cr, 2.0);
  cairo_move_to(cr, left, row - 5);
  cairo_line_to(cr, left, row);
  cairo_line_to(cr, left + pixels, row);
  cairo_line_to(cr, left + pixels, row - 5);
  cairo_stroke(cr);
  write(canvas, left + 3, row - 8, length_text(length));
}

void draw_header(const Canvas& canvas, const MapOptions& options) {
  cairo_t* cr = canvas.context();
  if (canvas.header() <= 0.0) return;
  cairo_rectangle(cr, 0, 0, canvas.width(), canvas.header());
  canvas.paint({1, 1, 1, 1});
  cairo_fill(cr);
  double column = 10.0;
  const double row = canvas.header() - 9.0;
  if (!options.title.empty()) {
    write(canvas, column, row, options.title);
    cairo_text_extents_t extents;
    cairo_text_extents(cr, options.title.c_str(), &extents);
    column += extents.x_advance + 24.0;
  }
  const double dashes[] = {7.0, 4.0};
  for (const MapTrail& trail : options.trails) {
    if (trail.label.empty()) continue;
    cairo_set_dash(cr, dashes, 2, 0.0);
    cairo_set_line_width(cr, 1.8);
    canvas.paint(trail.color);
    cairo_move_to(cr, column, row - 4);
    cairo_line_to(cr, column + 28, row - 4);
    cairo_stroke(cr);
    cairo_set_dash(cr, nullptr, 0, 0.0);
    write(canvas, column + 34, row, trail.label);
    cairo_text_extents_t extents;
    cairo_text_extents(cr, trail.label.c_str(), &extents);
    column += 34 + extents.x_advance + 18;
  }
}

}  // namespace

MapArea joined(const MapArea& a, const MapArea& b) {
  return {std::min(a.x_min, b.x_min), std::min(a.y_min, b.y_min), std::max(a.x_max, b.x_max),
          std::max(a.y_max, b.y_max)};
}

MapArea map_area(const Frame& frame, const std::vector<MapTrail>& trails) {
  MapArea area = nothing();
  for (std::size_t b = 0; b < frame.model->bodies.size(); ++b) {
    const Body& body = frame.model->bodies[b];
    if (body.removed) continue;
    enclose_body(area, *frame.model, body, frame.state.poses[b]);
  }
  for (const MapTrail& trail : trails) {
    for (const Vec3& p : trail.points) enclose(area, p.x(), p.y());
  }
  if (!(area.x_min <= area.x_max)) return {};
  const double margin =
      std::max({0.05 * (area.x_max - area.x_min), 0.05 * (area.y_max - area.y_min), 1e-3});
  return {area.x_min - margin, area.y_min - margin, area.x_max + margin, area.y_max + margin};
}

Result<std::string> map_picture(const Frame& frame, const MapOptions& options,
                                const std::string& ending) {
  if (ending != ".svg" && ending != ".png" && ending != ".pdf") {
    return fail("a map cannot be written as '" + ending + "'", "",
                "end the name with .svg, .png or .pdf");
  }
  if (options.width < 64 || options.width > 8000) {
    return fail("a map is 64 to 8000 pixels wide, not " + std::to_string(options.width));
  }
  const MapArea area = options.area ? *options.area : map_area(frame, options.trails);
  const bool sound = std::isfinite(area.x_min) && std::isfinite(area.x_max) &&
                     std::isfinite(area.y_min) && std::isfinite(area.y_max) &&
                     area.x_min < area.x_max && area.y_min < area.y_max;
  if (!sound) return fail("the map's area is empty", "", "give x_min < x_max and y_min < y_max");

  const bool labelled = std::any_of(options.trails.begin(), options.trails.end(),
                                    [](const MapTrail& t) { return !t.label.empty(); });
  std::string bytes;
  auto canvas =
      Canvas::make(ending, area, options.width, labelled || !options.title.empty() ? 28 : 0, bytes);
  if (!canvas) return tl::unexpected(canvas.error());
  cairo_t* cr = canvas->context();
  cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, kTextSize);
  canvas->paint(kPaper);
  cairo_paint(cr);
  draw_shapes(*canvas, frame, options.rays);
  if (options.grid) draw_grid(*canvas);
  draw_ghosts(*canvas, options.ghosts);
  draw_rays(*canvas, *frame.model, options.rays);
  draw_trails(*canvas, options.trails);
  if (options.names) draw_names(*canvas, frame);
  draw_scale_bar(*canvas);
  draw_header(*canvas, options);
  if (auto done = canvas->finish(ending, bytes); !done) return tl::unexpected(done.error());
  return bytes;
}

Result<> draw_map(const Frame& frame, const MapOptions& options, const std::string& path,
                  const OutputRules& rules) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  auto bytes = map_picture(frame, options, ending);
  if (!bytes) {
    bytes.error().where = path;
    return tl::unexpected(bytes.error());
  }
  const OutputKind kind = ending == ".png"   ? OutputKind::png
                          : ending == ".svg" ? OutputKind::svg
                                             : OutputKind::pdf;
  return write_output_file(path, kind, std::move(*bytes), rules);
}

}  // namespace cogrsim
