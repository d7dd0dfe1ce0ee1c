#include "cogrsim/rendering/standard_view.h"

#include <algorithm>
#include <cmath>

namespace cogrsim {

namespace {

// In the order of StandardView.
constexpr const char* kNames[] = {"front", "back", "left", "right", "top", "bottom", "iso"};

// Half extents and middle of a shape in its own frame [m].
Bounds local_bounds(const SceneModel& model, const Shape& shape) {
  Vec3 half = Vec3::Zero();
  switch (shape.type) {
    case ShapeType::plane:
      break;
    case ShapeType::box:
      half = 0.5 * shape.size;
      break;
    case ShapeType::sphere:
      half = Vec3::Constant(shape.radius);
      break;
    case ShapeType::cylinder:
      half = Vec3(shape.radius, shape.radius, 0.5 * shape.length);
      break;
    case ShapeType::capsule:
      half = Vec3(shape.radius, shape.radius, 0.5 * shape.length + shape.radius);
      break;
    case ShapeType::convex_mesh:
    case ShapeType::mesh: {
      const auto& vertices = model.meshes[static_cast<std::size_t>(shape.mesh)].vertices;
      Bounds b{vertices.front(), vertices.front()};
      for (const Vec3& v : vertices) {
        b.low = b.low.cwiseMin(v);
        b.high = b.high.cwiseMax(v);
      }
      return b;
    }
    case ShapeType::heightmap: {
      const HeightGrid& grid = model.heightmaps[static_cast<std::size_t>(shape.heightmap)];
      const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
      return {{-0.5 * grid.size_x, -0.5 * grid.size_y, *low},
              {0.5 * grid.size_x, 0.5 * grid.size_y, *high}};
    }
  }
  return {-half, half};
}

Vec3 corner_of(const Bounds& b, int i) {
  return {i & 1 ? b.high.x() : b.low.x(), i & 2 ? b.high.y() : b.low.y(),
          i & 4 ? b.high.z() : b.low.z()};
}

// Orientation of a camera that looks along `forward` (unit), with `up` towards the picture's top.
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

Bounds joined(const Bounds& a, const Bounds& b) {
  return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
}

Bounds visible_bounds(const Frame& frame) {
  const SceneModel& model = *frame.model;
  std::optional<Bounds> all;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.removed) continue;
    for (const Shape& shape : body.shapes) {
      if (!shape.visible || shape.type == ShapeType::plane) continue;
      const Pose X_WS = frame.state.poses[i] * shape.X_BS;
      const Bounds local = local_bounds(model, shape);
      for (int k = 0; k < 8; ++k) {
        const Vec3 p = X_WS * corner_of(local, k);
        if (!p.allFinite()) continue;
        all = all ? joined(*all, {p, p}) : Bounds{p, p};
      }
    }
  }
  return all.value_or(Bounds{});
}

Camera standard_camera(StandardView view, const Bounds& bounds, int width, int height, double fov) {
  constexpr double kMargin = 1.05;
  const Quat q = orientation_of(view);
  const Vec3 middle = 0.5 * (bounds.low + bounds.high);
  const double tan_x = std::tan(0.5 * fov) / kMargin;
  const double tan_y = tan_x * height / width;
  // From `back` behind the middle, a corner at (x, y, z) of the camera's axes is seen if
  // |y| <= (x + back) tan_x and |z| <= (x + back) tan_y.
  double back = 1e-3, reach = 1e-3;
  for (int i = 0; i < 8; ++i) {
    const Vec3 p = q.conjugate() * (corner_of(bounds, i) - middle);
    back = std::max({back, std::abs(p.y()) / tan_x - p.x(), std::abs(p.z()) / tan_y - p.x()});
    reach = std::max(reach, p.norm());
  }
  Camera camera = make_camera({middle - q * Vec3(back, 0, 0), q}, width, height, fov);
  camera.near = std::max(1e-3, 1e-3 * back);
  // Far enough for the ground behind, too.
  camera.far = 20.0 * (back + reach);
  return camera;
}

Pose view_pose(const Frame& frame, const ViewModel& view) {
  for (const NamedFrame& on : frame.model->frames) {
    if (on.name != view.name || on.removed || on.body == kWorld) continue;
    return frame.state.poses[static_cast<std::size_t>(on.body)] * on.X_BF;
  }
  return view.X_WV;
}

}  // namespace cogrsim
