#include "scene_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "look.h"
#include "overlay.h"
#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

constexpr int kShadowMapSize = 1024;
// A floor fades into the sky between these shares of the view's far end.
constexpr double kFadeBegin = 0.2, kFadeEnd = 0.9;
// Frames are kept for the next picture of their size, within these bounds.
constexpr std::size_t kTargetsKept = 8;
constexpr std::int64_t kSamplesKept = 32'000'000;  // of eight bytes each

Eigen::Vector3f linear(double r, double g, double b) {
  return Vec3(to_linear(r), to_linear(g), to_linear(b)).cast<float>();
}

CasterBounds bounds_of(const std::vector<Item>& items, const std::vector<Placement>& placements) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].type == ShapeType::plane) continue;
    box.extend((placements[i].middle.array() - items[i].bounding_radius).matrix());
    box.extend((placements[i].middle.array() + items[i].bounding_radius).matrix());
  }
  CasterBounds bounds;
  if (box.isEmpty()) return bounds;
  bounds.middle = box.center();
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].type == ShapeType::plane) continue;
    bounds.radius = std::max(
        bounds.radius, (placements[i].middle - bounds.middle).norm() + items[i].bounding_radius);
  }
  return bounds;
}

bool same(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Pose& x, const Pose& y) {
    return x.p == y.p && x.q.coeffs() == y.q.coeffs();
  });
}

/// Whether entry `i` is in both and the same.
template <class T>
bool kept(const std::vector<T>& before, const std::vector<T>& now, int i) {
  const auto at = static_cast<std::size_t>(i);
  return at < before.size() && at < now.size() && same_geometry(before[at], now[at]);
}

}  // namespace

SceneRenderer::SceneRenderer(const Gl& gl) : gl_(gl), contact_(gl) {
  gl_.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  gl_.FrontFace(GL_CW);  // rows count downwards, which mirrors everything
  gl_.CullFace(GL_BACK);
  gl_.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.GetIntegerv(GL_MAX_SAMPLES, &max_samples_);
  gl_.GenBuffers(1, &instances_);
  gl_.GenVertexArrays(1, &empty_array_);
  gl_.GenFramebuffers(1, &shadow_framebuffer_);
  gl_.GenVertexArrays(1, &line_array_);
  gl_.GenBuffers(1, &line_buffer_);
  gl_.BindVertexArray(line_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, line_buffer_);
  for (const GLuint location : {0U, 1U}) {
    gl_.EnableVertexAttribArray(location);
    gl_.VertexAttribPointer(location, 4, GL_FLOAT, GL_FALSE, sizeof(OverlayVertex),
                            reinterpret_cast<const void*>(std::size_t{16} * location));
  }
}

SceneRenderer::~SceneRenderer() {
  gl_.DeleteBuffers(1, &instances_);
  gl_.DeleteVertexArrays(1, &empty_array_);
  gl_.DeleteVertexArrays(1, &line_array_);
  gl_.DeleteBuffers(1, &line_buffer_);
  gl_.DeleteFramebuffers(1, &shadow_framebuffer_);
  if (shadow_texture_ != 0) gl_.DeleteTextures(1, &shadow_texture_);
}

Result<std::vector<Picture>> SceneRenderer::render(const Frame& frame,
                                                   const std::vector<RenderRequest>& requests) {
  if (frame.model != model_) {
    if (Result<> taken = take_model(frame.model); !taken) {
      return tl::unexpected<Error>(taken.error());
    }
  }
  take_poses(frame.state.poses);
  std::vector<Picture> pictures;
  for (const RenderRequest& request : requests) {
    Result<Picture> picture = take_picture(request);
    if (!picture) return tl::unexpected<Error>(picture.error());
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

Result<> SceneRenderer::take_model(const SceneModelPtr& model) {
  Result<std::vector<Item>> items = collect_items(*model, store_);
  if (!items) return tl::unexpected<Error>(items.error());
  for (auto it = meshes_.begin(); it != meshes_.end();) {
    const auto& [type, index] = it->first;
    const bool keep = model_ != nullptr && (type == ShapeType::heightmap
                                                ? kept(model_->heightmaps, model->heightmaps, index)
                                                : kept(model_->meshes, model->meshes, index));
    it = keep ? std::next(it) : meshes_.erase(it);
  }
  textured_.clear();
  items_ = std::move(*items);
  for (auto it = textures_.begin(); it != textures_.end();) {
    const bool used = std::any_of(items_.begin(), items_.end(), [&](const Item& item) {
      return item.picture.get() == it->first || item.floor_picture.get() == it->first;
    });
    it = used ? std::next(it) : textures_.erase(it);
  }
  for (const Item& item : items_) {
    for (const Image* picture : {item.picture.get(), item.floor_picture.get()}) {
      if (picture == nullptr) continue;
      std::unique_ptr<Texture>& texture = textures_[picture];
      if (texture == nullptr) texture = std::make_unique<Texture>(gl_, *picture);
    }
  }
  lights_ = lights_of(*model);
  contact_.take_model(model);
  model_ = model;
  poses_.clear();
  placements_.clear();
  return {};
}

void SceneRenderer::take_poses(const std::vector<Pose>& poses) {
  if (!poses_.empty() && same(poses, poses_)) return;
  poses_ = poses;
  placements_ = place_items(items_, poses);
  casters_ = bounds_of(items_, placements_);
  shadows_drawn_ = contact_drawn_ = false;
}

const Geometry& SceneRenderer::geometry_of(std::size_t index, int segments) {
  const Item& item = items_[index];
  if (item.picture != nullptr) {
    std::unique_ptr<Geometry>& made = textured_[{index, segments}];
    if (made == nullptr) {
      const Triangles plain =
          item.closed() ? unit_shape(item.type, segments) : faces_of(*model_, *item.source);
      made = std::make_unique<Geometry>(gl_, textured(*model_, *item.source, plain));
    }
    return *made;
  }
  if (item.closed()) {
    std::unique_ptr<Geometry>& made = unit_shapes_[{item.type, segments}];
    if (made == nullptr) made = std::make_unique<Geometry>(gl_, unit_shape(item.type, segments));
    return *made;
  }
  const bool grid = item.type == ShapeType::heightmap;
  std::unique_ptr<Geometry>& made =
      meshes_[{item.type, grid ? item.source->heightmap : item.source->mesh}];
  if (made == nullptr) made = std::make_unique<Geometry>(gl_, faces_of(*model_, *item.source));
  return *made;
}

const Texture* SceneRenderer::texture_of(std::size_t index) const {
  const Image* picture = items_[index].picture.get();
  return picture == nullptr ? nullptr : textures_.at(picture).get();
}

Program& SceneRenderer::lit_program(bool shadows, bool textured, Look look) {
  const std::string letters = letters_of(lights_, shadows);
  std::unique_ptr<Program>& made = programs_[fmt::format(
      "{} {} {}", textured ? "textured" : "plain", static_cast<int>(look), letters)];
  if (made == nullptr) {
    made = std::make_unique<Program>(gl_, instanced_vertex_shader(true, textured),
                                     lit_fragment_shader(letters, textured, look));
    made->use();
    made->set("u_texture", 0);
    made->set("u_shadows", 1);
  }
  return *made;
}

Program& SceneRenderer::program(const std::string& name, std::string (*vertex)(),
                                std::string (*fragment)()) {
  std::unique_ptr<Program>& made = programs_[name];
  if (made == nullptr) made = std::make_unique<Program>(gl_, vertex(), fragment());
  return *made;
}

Target& SceneRenderer::target(Target::Kind kind, int width, int height, int samples) {
  const auto found = std::find_if(targets_.begin(), targets_.end(), [&](const auto& target) {
    return target->is(kind, width, height, samples);
  });
  if (found != targets_.end()) {
    std::rotate(targets_.begin(), found, found + 1);  // last used first
    return *targets_.front();
  }
  std::int64_t samples_kept = std::int64_t{width} * height * samples;
  for (const auto& kept : targets_) samples_kept += kept->sample_count();
  // The first one stays: it may be what is being copied from.
  while (targets_.size() > 1 && (targets_.size() >= kTargetsKept || samples_kept > kSamplesKept)) {
    samples_kept -= targets_.back()->sample_count();
    targets_.pop_back();
  }
  targets_.insert(targets_.begin(), std::make_unique<Target>(gl_, kind, width, height, samples));
  return *targets_.front();
}

void SceneRenderer::bind_instances(const Batch& batch) {
  gl_.BindVertexArray(batch.geometry->array());
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
  const GLsizei stride = sizeof(Instance);
  const auto point = [&](GLuint location, GLint size, std::size_t bytes) {
    gl_.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, stride,
                            reinterpret_cast<const void*>(batch.first * sizeof(Instance) + bytes));
  };
  for (GLuint i = 0; i < 3; ++i) point(kRows + i, 4, offsetof(Instance, rows) + 16 * i);
  point(kScale, 4, offsetof(Instance, scale));
  point(kColor, 4, offsetof(Instance, color));
  point(kBody, 1, offsetof(Instance, body));
}

void SceneRenderer::draw(const DrawList& list, bool transparent,
                         const std::function<void(const Batch&)>& use) {
  for (const Batch& batch : list.batches) {
    if (batch.transparent != transparent) continue;
    if (use) use(batch);
    bind_instances(batch);
    if (batch.cull) gl_.Enable(GL_CULL_FACE);
    gl_.DrawElementsInstanced(GL_TRIANGLES, batch.geometry->index_count(), GL_UNSIGNED_INT, nullptr,
                              static_cast<GLsizei>(batch.count));
    if (batch.cull) gl_.Disable(GL_CULL_FACE);
  }
}

void SceneRenderer::draw_edges(const DrawList& list, const View& view) {
  Program& edges = program("edges", edge_vertex_shader, edge_fragment_shader);
  edges.use();
  edges.set("u_clip", Eigen::Matrix4f(view.clip.cast<float>()));
  for (const Batch& batch : list.batches) {
    if (batch.floor || batch.transparent || batch.geometry->edge_count() == 0) continue;
    bind_instances(batch);
    gl_.DrawElementsInstanced(
        GL_LINES, batch.geometry->edge_count(), GL_UNSIGNED_INT,
        reinterpret_cast<const void*>(static_cast<std::size_t>(batch.geometry->index_count()) *
                                      sizeof(std::uint32_t)),
        static_cast<GLsizei>(batch.count));
  }
}

void SceneRenderer::upload(const DrawList& list) {
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(list.instances.size() * sizeof(Instance)),
                 list.instances.data(), GL_STREAM_DRAW);
}

void SceneRenderer::add_planes(DrawList& list, const View& view, const RenderRequest& request) {
  plane_patches_.clear();
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    if (item.type != ShapeType::plane ||
        std::binary_search(request.hidden_bodies.begin(), request.hidden_bodies.end(), item.body)) {
      continue;
    }
    // A square around the camera's foot on it, as large as the camera sees.
    const Placement& placement = placements_[i];
    const Vec3 camera_S = placement.R_WS.transpose() * (view.origin - placement.p_WS);
    double extent = 0.0;
    for (const double column : {0.0, double(view.width)}) {
      for (const double row : {0.0, double(view.height)}) {
        extent = std::max(extent, 1.01 * view.far * view.ray(column, row).norm());
      }
    }
    std::vector<Vec3> polygon;
    const double corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (const auto& corner : corners) {
      polygon.push_back(placement.R_WS *
                        Vec3(extent * corner[0], extent * corner[1], -camera_S.z()));
    }
    polygon = cut(std::move(polygon), view);
    if (polygon.size() < 3) continue;
    const Material& material = model_->materials[item.source->material];
    const Eigen::Vector2d size = material.texture_size.value_or(Eigen::Vector2d(1.0, 1.0));
    // Whole copies are taken off, so that the numbers stay small far from the origin.
    const Eigen::Vector2d start = (camera_S.head<2>().array() / size.array());
    const Eigen::Vector2d shift = start.array().floor();
    Triangles fan;
    for (const Vec3& corner : polygon) {
      Vertex vertex;
      const Vec3 normal = placement.R_WS.col(2), local = placement.R_WS.transpose() * corner;
      const Eigen::Vector2d uv =
          (local.head<2>().array() / size.array()).matrix() + (start - shift);
      for (int k = 0; k < 3; ++k) {
        vertex.position[k] = static_cast<float>(corner[k]);
        vertex.normal[k] = static_cast<float>(normal[k]);
      }
      vertex.uv = {static_cast<float>(uv.x()), static_cast<float>(1.0 - uv.y())};
      fan.vertices.push_back(vertex);
    }
    for (std::uint32_t k = 2; k < fan.vertices.size(); ++k) {
      fan.indices.insert(fan.indices.end(), {0, k - 1, k});
    }
    plane_patches_.push_back(std::make_unique<Geometry>(gl_, fan));
    const bool transparent = item.color[3] < 1.0F;
    const Texture* texture =
        request.illustrated ? textures_.at(item.floor_picture.get()).get() : texture_of(i);
    list.batches.push_back({plane_patches_.back().get(), texture, false, transparent,
                            request.illustrated, list.instances.size(), 1});
    list.instances.push_back(make_instance(item, Placement(), Vec3::Zero()));
    if (request.illustrated)
      std::copy(item.floor_color.begin(), item.floor_color.end(), list.instances.back().color);
  }
}

void SceneRenderer::draw_shadow_maps() {
  if (shadows_drawn_) return;
  shadows_drawn_ = true;
  int layers = 0;
  for (const Light& light : lights_) layers += light.shadows ? light.layer_count() : 0;
  if (layers == 0) return;
  gl_.ActiveTexture(GL_TEXTURE0 + 1);
  if (layers > shadow_layers_) {
    if (shadow_texture_ != 0) gl_.DeleteTextures(1, &shadow_texture_);
    gl_.GenTextures(1, &shadow_texture_);
    gl_.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_texture_);
    gl_.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, kShadowMapSize, kShadowMapSize,
                   layers, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
    const GLenum target = GL_TEXTURE_2D_ARRAY;
    gl_.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    gl_.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    const float far[] = {1.0F, 1.0F, 1.0F, 1.0F};
    gl_.TexParameterfv(target, GL_TEXTURE_BORDER_COLOR, far);
    gl_.TexParameteri(target, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl_.TexParameteri(target, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    shadow_layers_ = layers;
  }
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer_);
  const GLenum none = GL_NONE;
  gl_.DrawBuffers(1, &none);
  gl_.ReadBuffer(GL_NONE);
  gl_.Viewport(0, 0, kShadowMapSize, kShadowMapSize);
  gl_.DepthFunc(GL_LESS);
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5F, 4.0F);
  Program& program = this->program(
      "shadow", [] { return instanced_vertex_shader(false, false); }, shadow_fragment_shader);
  program.use();
  for (const Light& light : lights_) {
    if (!light.shadows) continue;
    int layer = light.layer;
    for (const ShadowMap& map : shadow_maps(light, casters_)) {
      gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadow_texture_, 0, layer++);
      const float far = 1.0F;
      gl_.ClearBufferfv(GL_DEPTH, 0, &far);
      if (casters_.radius <= 0.0) continue;
      View view;
      view.origin = map.origin;
      view.clip = map.clip;
      view.planes = clip_planes(map.clip);
      DrawOptions options;
      options.segments = 24;
      options.opaque_only = true;
      DrawList list = list_items(
          items_, placements_, view, options,
          [this](std::size_t i, int segments) -> const Geometry& {
            return geometry_of(i, segments);
          },
          nullptr);
      for (Batch& batch : list.batches) batch.cull = false;
      upload(list);
      program.set("u_clip", Eigen::Matrix4f(map.clip.cast<float>()));
      draw(list, false, nullptr);
    }
  }
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
}

void SceneRenderer::draw_contact() {
  if (contact_drawn_) return;
  contact_drawn_ = true;
  const std::optional<View> view = contact_.view_for(poses_);
  if (!view) return;
  constexpr int kSize = ContactShadows::kSize;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target(Target::Kind::data, kSize, kSize, 1).framebuffer());
  gl_.Viewport(0, 0, kSize, kSize);
  const float nothing[] = {1.0F, 0.0F, 0.0F, 0.0F};
  const float far = 1.0F;
  gl_.ClearBufferfv(GL_COLOR, 0, nothing);
  gl_.ClearBufferfv(GL_DEPTH, 0, &far);
  gl_.DepthFunc(GL_LESS);
  DrawOptions options;
  options.segments = 24;
  options.opaque_only = true;
  DrawList list = list_items(
      items_, placements_, *view, options,
      [this](std::size_t i, int segments) -> const Geometry& { return geometry_of(i, segments); },
      nullptr);
  for (Batch& batch : list.batches) batch.cull = false;
  upload(list);
  Program& program = this->program(
      "height", [] { return instanced_vertex_shader(false, false); }, height_fragment_shader);
  program.use();
  program.set("u_clip", Eigen::Matrix4f(view->clip.cast<float>()));
  draw(list, false, nullptr);
  std::vector<float> heights(2 * std::size_t{kSize} * kSize);
  gl_.ReadPixels(0, 0, kSize, kSize, GL_RG, GL_FLOAT, heights.data());
  contact_.take(heights);
}

void SceneRenderer::set_sky(Program& program, const RenderRequest& request) const {
  if (request.background.kind == Background::Kind::plain) {
    const Color& plain = request.background.color;
    for (const char* name : {"u_zenith", "u_horizon", "u_nadir"})
      program.set(name, linear(plain.r, plain.g, plain.b));
    return;
  }
  const auto linear = [](const Vec3& c) { return osmesa::linear(c.x(), c.y(), c.z()); };
  const Eigen::Vector3f horizon = linear(kHorizon);
  const bool floor = std::any_of(items_.begin(), items_.end(),
                                 [](const Item& item) { return item.type == ShapeType::plane; });
  program.set("u_zenith", linear(kZenith));
  program.set("u_horizon", horizon);
  // A floor fades into the haze above it.
  program.set("u_nadir", request.illustrated && floor ? horizon : linear(kNadir));
}

void SceneRenderer::draw_sky(const View& view, const RenderRequest& request) {
  Program& sky = program("sky", full_screen_vertex_shader, sky_fragment_shader);
  sky.use();
  const Vec3 corner = view.ray(0, 0);
  sky.set("u_corner", Eigen::Vector3f(corner.cast<float>()));
  sky.set("u_right", Eigen::Vector3f((view.ray(view.width, 0) - corner).cast<float>()));
  sky.set("u_down", Eigen::Vector3f((view.ray(0, view.height) - corner).cast<float>()));
  set_sky(sky, request);
  gl_.BindVertexArray(empty_array_);
  gl_.DepthFunc(GL_GEQUAL);
  gl_.DepthMask(GL_FALSE);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_GREATER);
}

void SceneRenderer::draw_color(const View& view, const RenderRequest& request, int samples) {
  if (request.shadows) draw_shadow_maps();
  if (request.illustrated && request.shadows) draw_contact();
  gl_.BindFramebuffer(GL_FRAMEBUFFER,
                      target(Target::Kind::color, view.width, view.height, samples).framebuffer());
  gl_.Viewport(0, 0, view.width, view.height);
  const Color& plain = request.background.color;
  const float clear[] = {static_cast<float>(to_linear(plain.r)),
                         static_cast<float>(to_linear(plain.g)),
                         static_cast<float>(to_linear(plain.b)), 1.0F};
  const float far = 0.0F;
  gl_.ClearBufferfv(GL_COLOR, 0, clear);
  gl_.ClearBufferfv(GL_DEPTH, 0, &far);
  gl_.DepthFunc(GL_GREATER);

  DrawOptions options;
  options.hidden_bodies = &request.hidden_bodies;
  options.pixel_tolerance = 0.1;
  DrawList list = list_items(
      items_, placements_, view, options,
      [this](std::size_t i, int segments) -> const Geometry& { return geometry_of(i, segments); },
      [this](std::size_t i) { return texture_of(i); });
  add_planes(list, view, request);
  upload(list);
  gl_.ActiveTexture(GL_TEXTURE0 + 1);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, shadow_texture_);
  gl_.ActiveTexture(GL_TEXTURE0);
  Program* current = nullptr;
  const Texture* bound = nullptr;
  std::vector<Program*> ready;
  const auto use = [&](const Batch& batch) {
    const Look look = !request.illustrated ? Look::plain
                      : batch.floor        ? Look::floor
                                           : Look::outlined;
    Program& wanted = lit_program(request.shadows, batch.texture != nullptr, look);
    if (&wanted != current) {
      current = &wanted;
      wanted.use();
      if (std::find(ready.begin(), ready.end(), &wanted) == ready.end()) {
        ready.push_back(&wanted);
        wanted.set("u_clip", Eigen::Matrix4f(view.clip.cast<float>()));
        set_lights(wanted, lights_, request.shadows, casters_, view, kShadowMapSize, look);
        if (look == Look::floor) {
          contact_.set(wanted, view);
          set_sky(wanted, request);
          wanted.set("u_fade", Eigen::Vector3f(static_cast<float>(kFadeBegin * view.far),
                                               static_cast<float>(kFadeEnd * view.far), 0.0F));
        }
      }
    }
    if (batch.texture != nullptr && batch.texture != bound) {
      bound = batch.texture;
      gl_.BindTexture(GL_TEXTURE_2D, bound->id());
    }
  };
  draw(list, false, use);
  if (request.background.kind == Background::Kind::sky) draw_sky(view, request);
  gl_.Enable(GL_BLEND);
  current = nullptr;
  gl_.DepthMask(GL_FALSE);
  if (request.illustrated) draw_edges(list, view);
  draw(list, true, use);
  draw_lines(view, request.camera, request.overlay);
  gl_.DepthMask(GL_TRUE);
  gl_.Disable(GL_BLEND);
}

void SceneRenderer::draw_lines(const View& view, const Camera& camera, const Overlay& overlay) {
  if (overlay.lines.empty()) return;
  const int across = static_cast<int>(std::lround(view.fx / camera.fx));
  const int down = static_cast<int>(std::lround(view.fy / camera.fy));
  program("overlay", overlay_vertex_shader, overlay_fragment_shader).use();
  gl_.BindVertexArray(line_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, line_buffer_);
  for (const bool on_top : {false, true}) {
    const std::vector<OverlayVertex> vertices =
        line_triangles(overlay.lines, on_top, view, across, down);
    if (vertices.empty()) continue;
    gl_.BufferData(GL_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(vertices.size() * sizeof(OverlayVertex)),
                   vertices.data(), GL_STREAM_DRAW);
    if (on_top) gl_.Disable(GL_DEPTH_TEST);
    gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
    gl_.Enable(GL_DEPTH_TEST);
  }
}

void SceneRenderer::read_color(const View& view, int samples, std::uint8_t* rgba) {
  if (samples > 1) {
    const GLuint from = target(Target::Kind::color, view.width, view.height, samples).framebuffer();
    const GLuint to = target(Target::Kind::color, view.width, view.height, 1).framebuffer();
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, from);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    gl_.BlitFramebuffer(0, 0, view.width, view.height, 0, 0, view.width, view.height,
                        GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, to);
  }
  gl_.ReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
}

void SceneRenderer::draw_data(const View& view, const RenderRequest& request, float* data) {
  gl_.BindFramebuffer(GL_FRAMEBUFFER,
                      target(Target::Kind::data, view.width, view.height, 1).framebuffer());
  gl_.Viewport(0, 0, view.width, view.height);
  const float nothing[] = {std::numeric_limits<float>::infinity(), -1.0F, 0.0F, 0.0F};
  const float far = 0.0F;
  gl_.ClearBufferfv(GL_COLOR, 0, nothing);
  gl_.ClearBufferfv(GL_DEPTH, 0, &far);
  gl_.DepthFunc(GL_GREATER);
  DrawOptions options;
  options.hidden_bodies = &request.hidden_bodies;
  options.pixel_tolerance = 0.05;
  options.relative_tolerance = 1e-4;
  DrawList list = list_items(
      items_, placements_, view, options,
      [this](std::size_t i, int segments) -> const Geometry& { return geometry_of(i, segments); },
      nullptr);
  add_planes(list, view, request);
  upload(list);
  Program& program = this->program(
      "data", [] { return instanced_vertex_shader(false, false); }, data_fragment_shader);
  program.use();
  program.set("u_clip", Eigen::Matrix4f(view.clip.cast<float>()));
  draw(list, false, nullptr);
  draw(list, true, nullptr);
  gl_.ReadPixels(0, 0, view.width, view.height, GL_RG, GL_FLOAT, data);
}

}  // namespace cogrsim::osmesa
