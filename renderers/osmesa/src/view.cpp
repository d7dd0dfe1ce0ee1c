#include "view.h"

namespace cogrsim::osmesa {

namespace {

/// Fills in `clip` and `planes`. Depth is reversed (1 near, 0 far), which with floats is about as
/// fine at 100 m as at 1. Row 0 of the picture is row 0 in memory, so y points down.
void finish(View& view) {
  const double w = view.width, h = view.height;
  Eigen::Matrix4d from_camera = Eigen::Matrix4d::Zero();
  from_camera.row(0) << 2.0 * view.cx / w - 1.0, -2.0 * view.fx / w, 0.0, 0.0;
  from_camera.row(1) << 2.0 * view.cy / h - 1.0, 0.0, -2.0 * view.fy / h, 0.0;
  const double depth = view.near / (view.far - view.near);
  from_camera.row(2) << -depth, 0.0, 0.0, depth * view.far;
  from_camera.row(3) << 1.0, 0.0, 0.0, 0.0;
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  turn.topLeftCorner<3, 3>() = view.R_WC.transpose();
  view.clip = from_camera * turn;
  view.planes = clip_planes(view.clip);
}

}  // namespace

std::array<Eigen::Vector4d, 6> clip_planes(const Eigen::Matrix4d& clip) {
  std::array<Eigen::Vector4d, 6> planes;
  for (int i = 0; i < 3; ++i) {
    planes[2 * i] = (clip.row(3) - clip.row(i)).transpose();
    // Depth runs from 0, the others from -1.
    planes[2 * i + 1] =
        (i == 2 ? clip.row(2).eval() : (clip.row(3) + clip.row(i)).eval()).transpose();
  }
  for (Eigen::Vector4d& plane : planes) plane /= plane.head<3>().norm();
  return planes;
}

Vec3 View::ray(double column, double row) const {
  return R_WC * Vec3(1.0, (cx - column) / fx, (cy - row) / fy);
}

View make_view(const Camera& camera) {
  View view;
  view.width = camera.width;
  view.height = camera.height;
  view.fx = camera.fx;
  view.fy = camera.fy;
  view.cx = camera.cx;
  view.cy = camera.cy;
  view.near = camera.near;
  view.far = camera.far;
  view.origin = camera.X_WC.p;
  view.R_WC = camera.X_WC.q.normalized().toRotationMatrix();
  finish(view);
  return view;
}

View tile_of(const View& view, int column, int row, int width, int height, int across, int down) {
  View tile = view;
  tile.width = width * across;
  tile.height = height * down;
  tile.fx = view.fx * across;
  tile.fy = view.fy * down;
  tile.cx = (view.cx - column) * across;
  tile.cy = (view.cy - row) * down;
  finish(tile);
  return tile;
}

std::vector<Vec3> cut(std::vector<Vec3> polygon, const View& view) {
  std::vector<Vec3> kept;
  for (const Eigen::Vector4d& plane : view.planes) {
    kept.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double da = plane.head<3>().dot(a) + plane.w(), db = plane.head<3>().dot(b) + plane.w();
      if (da >= 0.0) kept.push_back(a);
      if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0))
        kept.push_back(a + (b - a) * (da / (da - db)));
    }
    polygon.swap(kept);
  }
  return polygon;
}

}  // namespace cogrsim::osmesa
