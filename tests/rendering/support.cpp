#include "support.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace cogrsim::test {

Renderer& renderer() {
  static PluginLoader loader;
  static const std::shared_ptr<Renderer> made = [] {
    Result<std::shared_ptr<Renderer>> loaded = load_renderer(loader);
    if (!loaded) {
      std::fprintf(stderr, "%s\n", loaded.error().text().c_str());
      std::exit(1);
    }
    return *loaded;
  }();
  return *made;
}

Frame frame_of(const SceneModelPtr& model) {
  Frame frame;
  frame.model = model;
  for (const Body& body : model->bodies) frame.state.poses.push_back(body.X_WB);
  return frame;
}

Pose look(const Vec3& eye, const Vec3& at) {
  const Vec3 x = (at - eye).normalized();
  // Straight down or up, left is y.
  const Vec3 y = std::abs(x.z()) < 0.999 ? Vec3::UnitZ().cross(x).normalized() : Vec3::UnitY();
  Mat3 axes;
  axes << x, y, x.cross(y);
  return {eye, Quat(axes)};
}

int colored(ModelBuilder& builder, double r, double g, double b) {
  const int index = builder.material("m" + std::to_string(builder.model.materials.size()), 0.5);
  builder.model.materials[index].color = {r, g, b, 1.0};
  return index;
}

RenderRequest request_of(const Camera& camera) {
  RenderRequest request;
  request.camera = camera;
  request.depth = request.segmentation = true;
  request.background.kind = Background::Kind::plain;
  request.background.color = {0, 0, 0, 1};
  return request;
}

Picture take(const SceneModelPtr& model, const RenderRequest& request) {
  Result<std::vector<Picture>> pictures = renderer().render(frame_of(model), {request});
  if (!pictures) throw std::runtime_error(pictures.error().text());
  return std::move(pictures->front());
}

int count_body(const Picture& picture, int body) {
  return static_cast<int>(std::count(picture.bodies.begin(), picture.bodies.end(), body));
}

namespace {
std::size_t index_of(const Picture& picture, int column, int row) {
  if (column < 0 || row < 0 || column >= picture.width || row >= picture.height) {
    throw std::out_of_range("a pixel outside of the picture");
  }
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
         static_cast<std::size_t>(column);
}
}  // namespace

Rgb pixel(const Picture& picture, int column, int row) {
  const std::uint8_t* p = picture.color.data.data() + 3 * index_of(picture, column, row);
  return {p[0], p[1], p[2]};
}
float depth_at(const Picture& picture, int column, int row) {
  return picture.depth[index_of(picture, column, row)];
}
int body_at(const Picture& picture, int column, int row) {
  return picture.bodies[index_of(picture, column, row)];
}

Eigen::Vector2d project(const Camera& camera, const Vec3& point) {
  const Vec3 p = camera.X_WC.inverse() * point;
  const double x = -p.y() / p.x(), y = -p.z() / p.x(), r2 = x * x + y * y;
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  const double bent_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double bent_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return {camera.cx + camera.fx * bent_x, camera.cy + camera.fy * bent_y};
}

}  // namespace cogrsim::test
