#include "cogrsim/rendering/standard_view.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/geometry/convex.h"

namespace cogrsim {

namespace {

// In the order of StandardView.
constexpr const char* kNames[] = {"front", "back", "left", "right", "top", "bottom", "iso"};

// Orientation of a camera with the viewing direction `forward` (unit) and `up` towards the image
// top.
Quat looking(const Vec3& forward, const Vec3& up) {
  Mat3 R;
  R.col(0) = forward;
  R.col(1) = up.cross(forward).normalized();
  R.col(2) = forward.cross(R.col(1));
  return Quat(R);
}

Quat orientation_of(StandardView view) {
  const Vec3 z = Vec3::UnitZ(), y = Vec3::UnitY();
  switch (view) {
    case StandardView::front:
      return looking({-1, 0, 0}, z);
    case StandardView::back:
      return looking({1, 0, 0}, z);
    case StandardView::left:
      return looking({0, -1, 0}, z);
    case StandardView::right:
      return looking({0, 1, 0}, z);
    case StandardView::top:
      return looking({0, 0, -1}, y);
    case StandardView::bottom:
      return looking({0, 0, 1}, y);
    case StandardView::iso:
      break;
  }
  return looking(Vec3(-1.0, -0.7, -0.8).normalized(), z);
}

}  // namespace

const char* to_string(StandardView view) { return kNames[static_cast<std::size_t>(view)]; }

std::vector<std::string> standard_view_names() { return {std::begin(kNames), std::end(kNames)}; }

std::optional<StandardView> standard_view(const std::string& name) {
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if (name == kNames[i]) return static_cast<StandardView>(i);
  }
  return std::nullopt;
}

geometry::Bounds visible_bounds(const Frame& frame, std::size_t body) {
  const SceneModel& model = *frame.model;
  geometry::Bounds all;
  if (model.bodies[body].removed) return all;
  for (const Shape& shape : model.bodies[body].shapes) {
    if (!shape.visible || shape.type == ShapeType::plane) continue;
    const Pose X_WS = frame.state.poses[body] * shape.X_BS;
    const geometry::Bounds local = geometry::local_bounds(model, shape);
    for (int k = 0; k < 8; ++k) {
      const Vec3 p = X_WS * local.corner(k);
      if (p.allFinite()) all.add(p);
    }
  }
  return all;
}

geometry::Bounds visible_bounds(const Frame& frame) {
  geometry::Bounds all;
  for (std::size_t i = 0; i < frame.model->bodies.size(); ++i) all.add(visible_bounds(frame, i));
  if (all.empty()) return {Vec3::Constant(-1.0), Vec3::Constant(1.0)};
  return all;
}

Camera standard_camera(StandardView view, const geometry::Bounds& bounds, int width, int height,
                       double fov) {
  constexpr double kMargin = 1.05;
  const Quat q = orientation_of(view);
  const Vec3 middle = bounds.middle();
  const double tan_x = std::tan(0.5 * fov) / kMargin;
  const double tan_y = tan_x * height / width;
  // At the distance `back` behind the middle, a corner at (x, y, z) in camera axes is visible if
  // |y| <= (x + back) tan_x and |z| <= (x + back) tan_y.
  double back = 1e-3, radius = 1e-3;
  for (int i = 0; i < 8; ++i) {
    const Vec3 p = q.conjugate() * (bounds.corner(i) - middle);
    back = std::max({back, std::abs(p.y()) / tan_x - p.x(), std::abs(p.z()) / tan_y - p.x()});
    radius = std::max(radius, p.norm());
  }
  Camera camera = make_camera({middle - q * Vec3(back, 0, 0), q}, width, height, fov);
  camera.near = std::max(1e-3, 1e-3 * back);
  // Far enough to include the ground in the background.
  camera.far = 20.0 * (back + radius);
  return camera;
}

Pose view_pose(const Frame& frame, const ViewModel& view) {
  for (const NamedFrame& on : frame.model->frames) {
    if (on.name != view.name || on.removed || on.body == kWorld) continue;
    return frame.state.poses[on.body] * on.X_BF;
  }
  return view.X_WV;
}

}  // namespace cogrsim
