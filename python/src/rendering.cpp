// Images: views of pictures, and render().
#include "rendering.h"

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/rendering/standard_view.h"
#include "frame.h"
#include "scene.h"

namespace cogrsim::python {

namespace {

/// Where a frame is seen from: a camera of the scene, one of its views, or a standard view.
Camera camera_of(const Frame& frame, const std::string& name, int width, int height, double fov) {
  if (!(fov >= 0.0 && fov < kPi))
    throw py::value_error(fmt::format("fov: expected 0 to pi rad, given {}", fov));
  for (const ViewModel& known : frame.model->views) {
    if (known.name == name)
      return make_camera(view_pose(frame, known), width, height, fov > 0.0 ? fov : known.fov);
  }
  if (const auto standard = standard_view(name)) {
    return standard_camera(*standard, visible_bounds(frame), width, height, fov > 0.0 ? fov : 0.8);
  }
  std::vector<std::string> names = standard_view_names();
  for (const ViewModel& known : frame.model->views) names.push_back(known.name);
  raise_unknown("view", name, names);
}

py::dict render(const PyFrame& self, const std::string& from, int width, int height, double fov,
                bool depth, bool labels, bool shadows, const std::shared_ptr<Scene>& scene) {
  const FramePtr frame = self.frame;
  RenderRequest request;
  request.camera = camera_of(*frame, from, width, height, fov);
  request.depth = depth;
  request.segmentation = labels;
  request.shadows = shadows;
  check(check_camera(request.camera));
  Result<std::vector<Picture>> pictures = [&]() -> Result<std::vector<Picture>> {
    const Unlock unlock;
    const std::shared_ptr<PluginLoader> loader =
        scene ? scene->loader : std::make_shared<PluginLoader>();
    auto renderer = load_renderer(*loader);
    if (!renderer) return tl::unexpected(renderer.error());
    return (*renderer)->render(*frame, {request});
  }();
  const auto picture =
      std::make_shared<const Picture>(std::move(value_of(std::move(pictures)).front()));
  py::dict out;
  out["color"] = color_of(picture);
  out["depth"] = depth_of(picture);
  out["labels"] = labels_of(picture);
  return out;
}

}  // namespace

py::object color_of(const PicturePtr& picture) {
  const Image& image = picture->color;
  if (image.data.empty()) return py::none();
  return view(py::dtype::of<std::uint8_t>(), {image.height, image.width, image.channels},
              {static_cast<py::ssize_t>(image.width) * image.channels, image.channels, 1},
              image.data.data(), owner_of(picture));
}

py::object depth_of(const PicturePtr& picture) {
  if (picture->depth.empty()) return py::none();
  return view(py::dtype::of<float>(), {picture->height, picture->width},
              {static_cast<py::ssize_t>(sizeof(float)) * picture->width, sizeof(float)},
              picture->depth.data(), owner_of(picture));
}

py::object labels_of(const PicturePtr& picture) {
  if (picture->bodies.empty()) return py::none();
  return view(
      py::dtype::of<std::int32_t>(), {picture->height, picture->width},
      {static_cast<py::ssize_t>(sizeof(std::int32_t)) * picture->width, sizeof(std::int32_t)},
      picture->bodies.data(), owner_of(picture));
}

void bind_rendering(py::module_& m) {
  m.def("_render", &render, py::arg("frame"), py::arg("view") = "iso", py::kw_only(),
        py::arg("width") = 640, py::arg("height") = 480, py::arg("fov") = 0.0,
        py::arg("depth") = false, py::arg("labels") = false, py::arg("shadows") = true,
        py::arg("scene") = nullptr);
}

}  // namespace cogrsim::python
