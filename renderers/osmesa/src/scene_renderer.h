// Draws frames. Lives in the thread that owns the context.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "cogrsim/rendering/renderer.h"
#include "contact.h"
#include "draw_list.h"
#include "gl_objects.h"
#include "lens.h"
#include "lights.h"
#include "shaders.h"

namespace cogrsim::osmesa {

class SceneRenderer {
 public:
  explicit SceneRenderer(const Gl& gl);
  ~SceneRenderer();

  /// Requests have been checked. Throws std::exception where the graphics library fails.
  Result<std::vector<Picture>> render(const Frame& frame,
                                      const std::vector<RenderRequest>& requests);

 private:
  Result<> take_model(const SceneModelPtr& model);
  void take_poses(const std::vector<Pose>& poses);
  void draw_shadow_maps();
  void draw_contact();
  Result<Picture> take_picture(const RenderRequest& request);
  Result<Picture> take_bent_picture(const RenderRequest& request);
  Picture take_straight_picture(const RenderRequest& request);
  void draw_color(const View& view, const RenderRequest& request, int samples);
  void read_color(const View& view, int samples, std::uint8_t* rgba);
  void draw_data(const View& view, const RenderRequest& request, float* data);

  const Geometry& geometry_of(std::size_t item, int segments);
  const Texture* texture_of(std::size_t item) const;
  Program& lit_program(bool shadows, bool textured, Look look);
  Program& program(const std::string& name, std::string (*vertex)(), std::string (*fragment)());
  Target& target(Target::Kind kind, int width, int height, int samples);
  /// Adds the planes to a list, cut to what the view sees; keeps their geometry until the next.
  void add_planes(DrawList& list, const View& view, const RenderRequest& request);
  void upload(const DrawList& list);
  void draw(const DrawList& list, bool transparent, const std::function<void(const Batch&)>& use);
  void bind_instances(const Batch& batch);
  void draw_edges(const DrawList& list, const View& view);
  void set_sky(Program& program, const RenderRequest& request) const;
  void draw_sky(const View& view, const RenderRequest& request);
  void draw_lines(const View& view, const Camera& camera, const Overlay& overlay);

  const Gl& gl_;
  GLuint instances_ = 0;  // buffer
  GLuint shadow_texture_ = 0, shadow_framebuffer_ = 0;
  int shadow_layers_ = 0;
  GLuint empty_array_ = 0;
  GLuint line_array_ = 0, line_buffer_ = 0;

  SceneModelPtr model_;
  std::vector<Item> items_;
  std::vector<Light> lights_;
  std::vector<Pose> poses_;
  std::vector<Placement> placements_;
  CasterBounds casters_;
  ContactShadows contact_;
  bool shadows_drawn_ = false, contact_drawn_ = false;

  // Unit shapes serve every model; meshes and textures go with theirs. Second: segments or mesh.
  std::map<std::pair<ShapeType, int>, std::unique_ptr<Geometry>> unit_shapes_, meshes_;
  std::map<std::pair<std::size_t, int>, std::unique_ptr<Geometry>> textured_;  // by item
  std::map<const Image*, std::unique_ptr<Texture>> textures_;
  std::vector<std::unique_ptr<Geometry>> plane_patches_;
  TextureStore store_;
  std::map<std::string, std::unique_ptr<Program>> programs_;
  std::vector<std::unique_ptr<Target>> targets_;
  std::vector<std::unique_ptr<Bending>> bendings_;
  int max_samples_ = 1;
  std::vector<std::uint8_t> rgba_;  // what was read, kept for its memory
  std::vector<float> data_;
};

}  // namespace cogrsim::osmesa
