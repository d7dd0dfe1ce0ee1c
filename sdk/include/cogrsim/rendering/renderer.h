// Rendering of images of a frame. A renderer is a plugin in backends/ that draws images for cameras
// and does not depend on a physics engine.
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

/// A pinhole camera with the lens distortion of Brown and Conrady, with the coefficients of OpenCV.
///
/// In the camera frame C the viewing direction is +x and z is up, so y points left in the image. A
/// point (x, y, z) in C with x > 0 is projected to X = -y/x, Y = -z/x (right and down). With
/// r^2 = X^2 + Y^2 the distortion is
///
///     X' = X (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 X Y + p2 (r^2 + 2 X^2)
///     Y' = Y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 Y^2) + 2 p2 X Y
///
/// and the point appears at column cx + fx X', row cy + fy Y', where (0, 0) is the outer corner of
/// the top left pixel and (0.5, 0.5) its centre.
struct Camera {
  Pose X_WC;                           ///< pose of C in the world
  int width = 320, height = 240;       ///< [pixel]
  double fx = 0, fy = 0;               ///< focal lengths [pixel]
  double cx = 0, cy = 0;               ///< principal point [pixel]
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3
  double near = 0.01, far = 100.0;     ///< clipping distances along x of C [m], 0 < near < far
};

/// A camera with square pixels, the principal point in the middle of the image, and the horizontal
/// field of view `fov` [rad], 0 < fov < pi.
COGRSIM_API Camera make_camera(const Pose& X_WC, int width, int height, double fov);

/// Checks that a camera can be rendered. Errors: a size is below 1 pixel, the image has more than
/// kMaxImagePixels, near >= far, a focal length is not positive, or a value is not finite. The
/// message names the value and its limit.
COGRSIM_API Result<> check_camera(const Camera& camera);

/// A line at its position in space. Surfaces in front of it hide it unless `on_top` is set.
struct OverlayLine {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< world [m]
  Color color{1, 0, 0, 1};
  double width = 1.5;  ///< [pixel]
  bool on_top = false;
};
/// A text at a position in space.
struct OverlayLabel {
  Vec3 at = Vec3::Zero();  ///< world [m]; the text starts to the right of it
  std::string text;        ///< UTF-8; characters that the font lacks are drawn as boxes
  Color color{1, 1, 1, 1};
};
/// Lines and texts that are drawn over the scene.
struct Overlay {
  std::vector<OverlayLine> lines;
  std::vector<OverlayLabel> labels;
};

/// Background of an image.
struct Background {
  enum class Kind { sky, plain } kind = Kind::sky;
  Color color{0.8, 0.85, 0.9, 1};  ///< of a plain background
};

/// Request for the images of one camera.
struct RenderRequest {
  Camera camera;
  bool color = true;
  bool depth = false;
  bool segmentation = false;
  bool shadows = true;
  int samples = 4;  ///< samples per pixel for anti-aliasing of the colour: 1 (none), 2, 4 or 8
  /// A picture for people, not what a camera would see: shapes have dark edges and outlines, floors
  /// have a grid, are paler than what has the same colour, and fade into the sky where they are far.
  bool illustrated = false;
  Background background;
  Overlay overlay;
  std::vector<int> hidden_bodies;  ///< sorted indices of bodies that are not drawn
};

/// The requested images of one camera; the others are empty. Row 0 is at the top.
struct Picture {
  int width = 0, height = 0;         ///< [pixel]
  Image color;                       ///< RGB
  std::vector<float> depth;          ///< along x of C [m] (height x width); infinite: background
  std::vector<std::int32_t> bodies;  ///< body indices (height x width); -1: background
};

/// A renderer. One object can render different scenes one after the other. The calls may come from
/// different threads, but must not overlap.
class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Name of the renderer, "osmesa".
  virtual const char* name() const = 0;

  /// Renders one picture per request, in their order, from the model and the state of a frame.
  /// Poses and shadow maps are computed once per frame; meshes and textures are reused as long as
  /// the frames have the same model. Errors: those of check_camera(), a missing texture file, or
  /// out of memory.
  virtual Result<std::vector<Picture>> render(const Frame& frame,
                                              const std::vector<RenderRequest>& requests) = 0;
};

/// Factory table of a renderer plugin.
struct RendererEntry {
  Renderer* (*create)(std::string* problem);  ///< nullptr: `problem` has the reason
  void (*destroy)(Renderer*);
};

class PluginLoader;
/// Loads the renderer with this name; empty: the standard renderer "osmesa". Its library stays
/// loaded as long as the renderer exists.
COGRSIM_API Result<std::shared_ptr<Renderer>> load_renderer(PluginLoader& loader,
                                                            const std::string& name = {});

}  // namespace cogrsim

/// COGRSIM_RENDERER(create, destroy, "osmesa", version("1.0.0"), …)
#define COGRSIM_RENDERER(create, destroy, name, ...)                \
  namespace {                                                       \
  const ::cogrsim::RendererEntry cogrsim_entry = {create, destroy}; \
  }                                                                 \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::renderer, name, &cogrsim_entry, ##__VA_ARGS__)
