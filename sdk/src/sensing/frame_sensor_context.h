// The context of sensors: ray caster, colours and images of one frame, computed at the first use.
#pragma once

#include <memory>
#include <optional>

#include "cogrsim/model/surface.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rays/ray_caster.h"
#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

/// There is one object per run. The renderer library is loaded at the first image, and the ray
/// caster is updated to the poses of a frame at the first ray of that frame, so that a run without
/// such sensors has no cost.
class FrameSensorContext final : public SensorContext {
 public:
  /// `loader` must outlive this object. `renderer` replaces the standard renderer unless it is
  /// nullptr.
  explicit FrameSensorContext(PluginLoader& loader, std::shared_ptr<Renderer> renderer = nullptr)
      : loader_(loader), renderer_(std::move(renderer)) {}

  /// Sets the frame to be measured.
  void show(FramePtr frame);
  /// Releases the frame, so that its memory can be reused; ray caster and renderer are retained.
  void hide() { frame_.reset(); }

  const Frame& frame() const override { return *frame_; }
  const RayCaster& rays() override;
  Color surface_color(const RayHit& hit) override;
  Result<std::vector<Picture>> render(const std::vector<RenderRequest>& requests) override;

 private:
  PluginLoader& loader_;
  FramePtr frame_;
  std::optional<RayCaster> rays_;
  bool rays_current_ = false;
  TextureStore textures_;
  std::shared_ptr<Renderer> renderer_;
  std::optional<Error> no_renderer_;  ///< error of loading the renderer; it is not tried again
};

}  // namespace cogrsim
