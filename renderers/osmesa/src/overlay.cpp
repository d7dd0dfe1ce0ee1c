#include "overlay.h"

#include <algorithm>
#include <cmath>

#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

// Lines lie this much nearer than they are, so that one drawn on a surface is seen.
constexpr double kLineLift = 2e-3;

/// Cuts a segment to the inner side of a plane; false: nothing is left.
bool cut_segment(Vec3& a, Vec3& b, const Eigen::Vector4d& plane) {
  const double da = plane.head<3>().dot(a) + plane.w(), db = plane.head<3>().dot(b) + plane.w();
  if (da < 0.0 && db < 0.0) return false;
  if (da < 0.0) a += (b - a) * (da / (da - db));
  if (db < 0.0) b += (a - b) * (db / (db - da));
  return true;
}

}  // namespace

std::vector<OverlayVertex> line_triangles(const std::vector<OverlayLine>& lines, bool on_top,
                                          const View& view, int across, int down) {
  std::vector<OverlayVertex> out;
  for (const OverlayLine& line : lines) {
    if (line.on_top != on_top || !line.from.allFinite() || !line.to.allFinite()) continue;
    Vec3 ends[2] = {line.from - view.origin, line.to - view.origin};
    if (!cut_segment(ends[0], ends[1], view.planes[4]) ||
        !cut_segment(ends[0], ends[1], view.planes[5])) {
      continue;
    }
    const Eigen::Vector4d clip[2] = {view.clip * ends[0].homogeneous(),
                                     view.clip * ends[1].homogeneous()};
    // In pixels of the picture; half a width to all sides, at the ends too, so that joints close.
    const Eigen::Array2d half_size(0.5 * view.width / across, 0.5 * view.height / down);
    const Eigen::Vector2d from = (clip[0].head<2>() / clip[0].w()).array() * half_size;
    const Eigen::Vector2d to = (clip[1].head<2>() / clip[1].w()).array() * half_size;
    const double length = (to - from).norm();
    const Eigen::Vector2d along =
        0.5 * line.width *
        (length > 1e-9 ? Eigen::Vector2d((to - from) / length) : Eigen::Vector2d(1.0, 0.0));
    const Eigen::Vector2d side(-along.y(), along.x());
    const auto corner = [&](int end, double turn) {
      const Eigen::Vector2d move = (end == 0 ? -along : along) + turn * side;
      Eigen::Vector4d p = clip[end];
      p.head<2>() += ((move.array() / half_size) * p.w()).matrix();
      p.z() = std::min(p.z() * (1.0 + kLineLift), p.w());
      OverlayVertex vertex;
      for (int i = 0; i < 4; ++i) vertex.clip[i] = static_cast<float>(p[i]);
      vertex.color[0] = static_cast<float>(to_linear(line.color.r));
      vertex.color[1] = static_cast<float>(to_linear(line.color.g));
      vertex.color[2] = static_cast<float>(to_linear(line.color.b));
      vertex.color[3] = static_cast<float>(line.color.a);
      return vertex;
    };
    const OverlayVertex a = corner(0, -1), b = corner(0, 1), c = corner(1, 1), d = corner(1, -1);
    out.insert(out.end(), {a, b, c, a, c, d});
  }
  return out;
}

}  // namespace cogrsim::osmesa
