// Pictures of a frame. A renderer is a plugin, in backends/, that knows graphics and nothing of
// physics; the SDK asks it for pictures by camera.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/image.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

/// A pinhole camera with lens distortion (Brown and Conrady, as OpenCV numbers the coefficients).
///
/// Camera frame C: looks along +x, z up, so y points left in the picture. A point (x, y, z) in C
/// with x > 0 falls on X = -y/x, Y = -z/x (right and down), is distorted with r^2 = X^2 + Y^2,
///
///     X' = X (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 X Y + p2 (r^2 + 2 X^2)
///     Y' = Y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 Y^2) + 2 p2 X Y
///
/// and is seen at column cx + fx X', row cy + fy Y', where (0, 0) is the outer corner of the top
/// left pixel, so that its middle is (0.5, 0.5).
struct Camera {
  Pose X_WC;
  int width = 320, height = 240;       ///< [pixel]
  double fx = 0, fy = 0;               ///< focal lengths [pixel]
  double cx = 0, cy = 0;               ///< principal point [pixel]
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3
  double near = 0.01, far = 100.0;     ///< [m], 0 < near < far; along x of C
};

/// Square pixels, principal point in the middle; `fov` horizontal [rad], 0 to pi.
COGRSIM_API Camera make_camera(const Pose& X_WC, int width, int height, double fov);

/// Refuses what cannot be rendered: sizes below 1 or above kMaxImagePixels, near >= far, focal
/// lengths that are not positive, anything not finite. The message says which and the limit.
COGRSIM_API Result<> check_camera(const Camera& camera);

/// Drawn over the scene, in its place in space (hidden by what is in front unless `on_top`).
struct OverlayLine {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< world [m]
  Color color{1, 0, 0, 1};
  double width = 1.5;  ///< [pixel]
  bool on_top = false;
};
struct OverlayLabel {
  Vec3 at = Vec3::Zero();  ///< world [m]; the text starts right of it
  std::string text;        ///< UTF-8; letters the font lacks are drawn as boxes
  Color color{1, 1, 1, 1};
};
struct Overlay {
  std::vector<OverlayLine> lines;
  std::vector<OverlayLabel> labels;
};

struct Background {
  enum class Kind { sky, plain } kind = Kind::sky;
  Color color{0.8, 0.85, 0.9, 1};  ///< of a plain one
};

struct RenderRequest {
  Camera camera;
  bool color = true;
  bool depth = false;
  bool segmentation = false;
  bool shadows = true;
  int samples = 4;  ///< anti-aliasing of colour: 1 (none), 2, 4 or 8 per pixel
  Background background;
  Overlay overlay;
  std::vector<int> hidden_bodies;  ///< not drawn, sorted: a camera may not see its own housing
};

/// What was asked for; the rest is empty. Row 0 at the top.
struct Picture {
  int width = 0, height = 0;
  Image color;                       ///< RGB
  std::vector<float> depth;          ///< along x of C [m] (height x width); infinite: background
  std::vector<std::int32_t> bodies;  ///< SceneModel::bodies (height x width); -1: background
};

/// One object may serve many scenes, one after the other. Calls may come from any thread, one at a
/// time.
class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual const char* name() const = 0;

  /// Pictures of one frame (needs: model, state), one for each request in order. What several
  /// requests or calls have in common for one frame (poses, shadow maps) is done once; meshes and
  /// textures are kept from call to call while frames bring the same model.
  /// Errors: check_camera's, a texture that went away, out of memory.
  virtual Result<std::vector<Picture>> render(const Frame& frame,
                                              const std::vector<RenderRequest>& requests) = 0;
};

/// Factory table of a renderer plugin.
struct RendererEntry {
  Renderer* (*create)(std::string* problem);  ///< nullptr: `problem` says why
  void (*destroy)(Renderer*);
};

class PluginLoader;
/// The renderer called `name`; empty: the standard one, "osmesa". Keeps its library loaded.
COGRSIM_API Result<std::shared_ptr<Renderer>> load_renderer(PluginLoader& loader,
                                                            const std::string& name = {});

}  // namespace cogrsim

/// COGRSIM_RENDERER(create, destroy, "osmesa", version("1.0.0"), …)
#define COGRSIM_RENDERER(create, destroy, name, ...)                \
  namespace {                                                       \
  const ::cogrsim::RendererEntry cogrsim_entry = {create, destroy}; \
  }                                                                 \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::renderer, name, &cogrsim_entry, ##__VA_ARGS__)
