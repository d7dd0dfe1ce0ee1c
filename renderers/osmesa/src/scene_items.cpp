#include "scene_items.h"

#include <cmath>

#include "cogrsim/geometry/convex.h"
#include "cogrsim/rendering/looks.h"

#include "geometry.h"
#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

/// A metre of a floor that has no chosen appearance: lines every metre, fainter ones every 10 cm.
std::shared_ptr<const Image> floor_grid() {
  static const std::shared_ptr<const Image> grid = [] {
    constexpr int kSize = 500, kCell = 50;  // [pixel], 2 mm each
    auto image = std::make_shared<Image>();
    image->width = image->height = kSize;
    image->channels = 1;
    for (int row = 0; row < kSize; ++row) {
      for (int column = 0; column < kSize; ++column) {
        const auto on = [&](int every, int half) {
          const auto near = [&](int at) { return (at + half) % every < 2 * half; };
          return near(row) || near(column);
        };
        image->data.push_back(on(kSize, 2) ? 196 : on(kCell, 1) ? 228 : 255);
      }
    }
    return image;
  }();
  return grid;
}

std::array<float, 4> linear(const Color& color) {
  return {static_cast<float>(to_linear(color.r)), static_cast<float>(to_linear(color.g)),
          static_cast<float>(to_linear(color.b)), static_cast<float>(color.a)};
}

}  // namespace

Result<std::vector<Item>> collect_items(const SceneModel& model, TextureStore& textures) {
  std::vector<Item> items;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.removed) continue;
    for (std::size_t s = 0; s < body.shapes.size(); ++s) {
      const Shape& shape = body.shapes[s];
      if (!shape.visible) continue;
      const Material& material = model.materials[shape.material];
      Item item;
      item.body = static_cast<int>(b);
      item.shape = static_cast<int>(s);
      item.type = shape.type;
      item.source = &shape;
      item.X_BS = shape.X_BS;
      item.scale = unit_scale(shape);
      item.color = linear(shown_color(model, item.body, shape));
      if (!material.texture.empty()) {
        item.picture = textures.texture(material);
        if (item.picture == nullptr) return fail(textures.problem(), shape.name);
      } else if (shape.type == ShapeType::plane && !has_looks(material)) {
        item.picture = floor_grid();
      }
      if (shape.type == ShapeType::plane) {
        item.floor_color = linear(floor_color(model, item.body, shape));
        item.floor_picture = item.picture != nullptr ? item.picture : floor_grid();
      }
      const geometry::Ball ball = geometry::bounding_ball(model, shape);
      item.middle = ball.middle;
      // A polygon of a circle's area reaches beyond it, 5.4 % with 8 corners.
      item.bounding_radius = shape.type == ShapeType::plane ? 0.0 : 1.06 * ball.radius;
      const bool round = shape.type == ShapeType::sphere || shape.type == ShapeType::cylinder ||
                         shape.type == ShapeType::capsule;
      if (round) item.curve = shape.radius;
      items.push_back(std::move(item));
    }
  }
  return items;
}

std::vector<Placement> place_items(const std::vector<Item>& items, const std::vector<Pose>& poses) {
  std::vector<Placement> out;
  out.reserve(items.size());
  for (const Item& item : items) {
    const Pose& X_WB = poses[item.body];
    Placement placement;
    placement.R_WS = (X_WB.q * item.X_BS.q).normalized().toRotationMatrix();
    placement.p_WS = X_WB * item.X_BS.p;
    placement.middle = placement.p_WS + placement.R_WS * item.middle;
    out.push_back(placement);
  }
  return out;
}

}  // namespace cogrsim::osmesa
