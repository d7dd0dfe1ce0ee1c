// What sensors look through: rays, colours and pictures of one frame, made when first asked for.
#pragma once

#include <memory>
#include <optional>

#include "cogrsim/model/surface.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/rays/ray_caster.h"
#include "cogrsim/rendering/renderer.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

/// One object per run. The renderer's library is looked for at the first picture, and the ray
/// caster is brought to a frame's poses at that frame's first ray: a run without such sensors pays
/// for neither.
class FrameSensing final : public Sensing {
 public:
  /// `loader` must outlive this object. `renderer`: used instead of the standard one if given.
  explicit FrameSensing(PluginLoader& loader, std::shared_ptr<Renderer> renderer = nullptr)
      : loader_(loader), renderer_(std::move(renderer)) {}

  /// The frame that is looked at from now on.
  void show(FramePtr frame);
  /// Lets go of the frame, so that its memory can be used again; caster and renderer are kept.
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
  std::optional<Error> no_renderer_;  ///< why none can be had; not tried again every time
};

}  // namespace cogrsim
