#include "lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

using Eigen::Vector2d;

// Rays farther from the axis than this are left out [tangent]: 83 degrees.
constexpr double kWidest = 8.0;

Eigen::Matrix2d slope(const Camera& camera, const Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double rise = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // d radial / dx = rise x
  Eigen::Matrix2d out;
  out(0, 0) = radial + rise * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
  out(0, 1) = rise * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  out(1, 0) = rise * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  out(1, 1) = radial + rise * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  return out;
}

}  // namespace

bool has_distortion(const Camera& camera) {
  return std::any_of(camera.distortion.begin(), camera.distortion.end(),
                     [](double k) { return k != 0.0; });
}

Vector2d distort(const Camera& camera, const Vector2d& point) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = point.x(), y = point.y(), r2 = point.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

std::optional<Vector2d> undistort(const Camera& camera, const Vector2d& bent) {
  // From the middle outwards in small steps, each put right by Newton's method: so the answer lies
  // on the branch that begins there, and the path ends where the formula folds back.
  const int steps = 1 + static_cast<int>(std::ceil(4.0 * bent.norm()));
  Vector2d at = Vector2d::Zero();
  for (int step = 1; step <= steps; ++step) {
    const Vector2d goal = bent * (static_cast<double>(step) / steps);
    bool there = false;
    for (int i = 0; i < 30 && !there; ++i) {
      const Eigen::Matrix2d jacobian = slope(camera, at);
      if (!(jacobian.determinant() > 1e-6)) return std::nullopt;
      const Vector2d error = distort(camera, at) - goal;
      there = error.norm() < 1e-10 * (1.0 + goal.norm());
      Vector2d move = jacobian.inverse() * error;
      const double limit = 0.5;
      if (move.norm() > limit) move *= limit / move.norm();
      at -= move;
      if (!(at.norm() < kWidest)) return std::nullopt;
    }
    if (!there) return std::nullopt;
  }
  return at;
}

bool Bending::serves(const Camera& camera) const {
  return lens.width == camera.width && lens.height == camera.height && lens.fx == camera.fx &&
         lens.fy == camera.fy && lens.cx == camera.cx && lens.cy == camera.cy &&
         lens.distortion == camera.distortion;
}

Result<Bending> make_bending(const Camera& camera) {
  Bending out;
  out.lens = camera;
  std::vector<Vector2d> points;
  Eigen::AlignedBox2d box;
  double finest = 1.0;
  const Vector2d nothing = Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Vector2d bent((column + 0.5 - camera.cx) / camera.fx,
                          (row + 0.5 - camera.cy) / camera.fy);
      const std::optional<Vector2d> point = undistort(camera, bent);
      points.push_back(point.value_or(nothing));
      if (!point) continue;
      box.extend(*point);
      // Where the lens magnifies, the straight picture needs more pixels; four times are enough.
      finest = std::max(finest, std::min(4.0, std::sqrt(slope(camera, *point).determinant())));
    }
  }
  if (box.isEmpty()) return fail("the lens distortion leaves nothing to see in the whole picture");
  // A margin for the pixels around the outermost points.
  const double fx = camera.fx * finest, fy = camera.fy * finest;
  const double left = std::floor(box.min().x() * fx) - 2, top = std::floor(box.min().y() * fy) - 2;
  const double width = std::ceil(box.max().x() * fx) + 2 - left;
  const double height = std::ceil(box.max().y() * fy) + 2 - top;
  if (width * height > static_cast<double>(kMaxImagePixels)) {
    return fail(fmt::format("the lens distortion needs a straight picture of {:.0f} x {:.0f} "
                            "pixels; the limit is {} pixels",
                            width, height, kMaxImagePixels),
                "", "make the picture smaller or the distortion weaker");
  }
  out.straight = camera;
  out.straight.distortion = {};
  out.straight.fx = fx;
  out.straight.fy = fy;
  out.straight.cx = -left;
  out.straight.cy = -top;
  out.straight.width = static_cast<int>(width);
  out.straight.height = static_cast<int>(height);
  out.pixels.reserve(points.size());
  for (const Vector2d& point : points) {
    out.pixels.push_back(Vector2d(point.x() * fx - left, point.y() * fy - top).cast<float>());
  }
  return out;
}

Image bend_color(const Bending& bending, const Image& straight) {
  Image out;
  out.width = bending.lens.width;
  out.height = bending.lens.height;
  out.data.assign(3 * bending.pixels.size(), 0);
  const int w = straight.width, h = straight.height;
  for (std::size_t i = 0; i < bending.pixels.size(); ++i) {
    const Eigen::Vector2f& pixel = bending.pixels[i];
    if (std::isnan(pixel.x())) continue;
    const float x = std::clamp(pixel.x() - 0.5F, 0.0F, static_cast<float>(w - 1));
    const float y = std::clamp(pixel.y() - 0.5F, 0.0F, static_cast<float>(h - 1));
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, w - 1), y1 = std::min(y0 + 1, h - 1);
    const float u = x - static_cast<float>(x0), v = y - static_cast<float>(y0);
    const std::uint8_t *a = straight.pixel(x0, y0), *b = straight.pixel(x1, y0),
                       *c = straight.pixel(x0, y1), *d = straight.pixel(x1, y1);
    for (std::size_t k = 0; k < 3; ++k) {
      const float upper = decode(a[k]) * (1.0F - u) + decode(b[k]) * u;
      const float lower = decode(c[k]) * (1.0F - u) + decode(d[k]) * u;
      out.data[3 * i + k] = encode(upper * (1.0F - v) + lower * v);
    }
  }
  return out;
}

void bend_data(const Bending& bending, const Picture& straight, Picture& out) {
  const std::size_t count = bending.pixels.size();
  const auto times = static_cast<float>(straight.width / bending.straight.width);
  if (!straight.depth.empty()) out.depth.assign(count, std::numeric_limits<float>::infinity());
  if (!straight.bodies.empty()) out.bodies.assign(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2f pixel = times * bending.pixels[i];
    if (std::isnan(pixel.x())) continue;
    const int column = std::clamp(static_cast<int>(pixel.x()), 0, straight.width - 1);
    const int row = std::clamp(static_cast<int>(pixel.y()), 0, straight.height - 1);
    const std::size_t from =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(straight.width) +
        static_cast<std::size_t>(column);
    if (!straight.depth.empty()) out.depth[i] = straight.depth[from];
    if (!straight.bodies.empty()) out.bodies[i] = straight.bodies[from];
  }
}

}  // namespace cogrsim::osmesa
