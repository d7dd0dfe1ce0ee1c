#include "sensing/frame_sensor_context.h"

#include "cogrsim/plugin/crash_report.h"

namespace cogrsim {

void FrameSensorContext::show(FramePtr frame) {
  frame_ = std::move(frame);
  rays_current_ = false;
}

const RayCaster& FrameSensorContext::rays() {
  if (!rays_) rays_.emplace();
  if (!rays_current_) rays_->update(frame_->model, frame_->state.poses, RayTargets::visible);
  rays_current_ = true;
  return *rays_;
}

Color FrameSensorContext::surface_color(const RayHit& hit) {
  if (!hit || hit.shape < 0) return {};
  const SceneModel& model = *frame_->model;
  const auto index = static_cast<std::size_t>(hit.body);
  const Shape& shape = model.bodies[index].shapes[hit.shape];
  const Material& material = model.materials[shape.material];
  const auto texture = textures_.texture(material);
  if (!texture) return material.color;
  const Pose X_SW = (frame_->state.poses[index] * shape.X_BS).inverse();
  // Rays hit both sides of a surface; texture coordinates are defined on the outer side.
  const Vec3 outward = X_SW.q * (hit.inside ? Vec3(-hit.normal) : hit.normal);
  const Color texel =
      sample(*texture, texture_coordinates(model, shape, X_SW * hit.point, outward, hit.triangle));
  return {texel.r * material.color.r, texel.g * material.color.g, texel.b * material.color.b,
          texel.a * material.color.a};
}

Result<std::vector<Picture>> FrameSensorContext::render(
    const std::vector<RenderRequest>& requests) {
  if (no_renderer_) return tl::unexpected(*no_renderer_);
  if (!renderer_) {
    auto loaded = load_renderer(loader_);
    if (!loaded) {
      no_renderer_ = loaded.error();
      return tl::unexpected(*no_renderer_);
    }
    renderer_ = std::move(*loaded);
  }
  const PluginCall call("renderer", "", "", "", "in a picture", frame_->time);
  return renderer_->render(*frame_, requests);
}

}  // namespace cogrsim
