#include "scene_items.h"

#include <cmath>

#include "cogrsim/rendering/looks.h"

#include "geometry.h"
#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

/// The sphere around a shape that is given by points: middle of their box, and the farthest.
template <class Each>
void enclose(Item& item, const Each& each_point) {
  Eigen::AlignedBox3d box;
  each_point([&](const Vec3& p) { box.extend(p); });
  if (box.isEmpty()) return;
  item.middle = box.center();
  each_point([&](const Vec3& p) { item.reach = std::max(item.reach, (p - item.middle).norm()); });
}

void measure(Item& item, const SceneModel& model) {
  const Shape& shape = *item.source;
  switch (shape.type) {
    case ShapeType::box:
      item.reach = 0.5 * shape.size.norm();
      break;
    case ShapeType::sphere:
      item.reach = item.curve = shape.radius;
      break;
    case ShapeType::cylinder:
      item.reach = std::hypot(shape.radius, 0.5 * shape.length);
      item.curve = shape.radius;
      break;
    case ShapeType::capsule:
      item.reach = shape.radius + 0.5 * shape.length;
      item.curve = shape.radius;
      break;
    case ShapeType::plane:
      break;
    case ShapeType::convex_mesh:
    case ShapeType::mesh: {
      const TriangleMesh& mesh = model.meshes[static_cast<std::size_t>(shape.mesh)];
      enclose(item, [&](const auto& use) {
        for (const Vec3& v : mesh.vertices) use(v);
      });
      break;
    }
    case ShapeType::heightmap: {
      const HeightGrid& grid = model.heightmaps[static_cast<std::size_t>(shape.heightmap)];
      enclose(item, [&](const auto& use) {
        for (const double z : grid.heights) {
          use(Vec3(-0.5 * grid.size_x, -0.5 * grid.size_y, z));
          use(Vec3(0.5 * grid.size_x, 0.5 * grid.size_y, z));
        }
      });
      break;
    }
  }
  item.reach *= 1.06;  // a polygon of a circle's area reaches beyond it, 5.4 % with 8 corners
}

/// A metre of a floor that nobody chose the looks of: lines every metre, fainter ones every 10 cm.
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

}  // namespace

Result<std::vector<Item>> collect_items(const SceneModel& model, TextureStore& textures) {
  std::vector<Item> items;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.removed) continue;
    for (std::size_t s = 0; s < body.shapes.size(); ++s) {
      const Shape& shape = body.shapes[s];
      if (!shape.visible) continue;
      const Material& material = model.materials[static_cast<std::size_t>(shape.material)];
      Item item;
      item.body = static_cast<int>(b);
      item.shape = static_cast<int>(s);
      item.type = shape.type;
      item.source = &shape;
      item.X_BS = shape.X_BS;
      item.scale = unit_scale(shape);
      const Color color = shown_color(model, item.body, shape);
      item.color = {static_cast<float>(to_linear(color.r)), static_cast<float>(to_linear(color.g)),
                    static_cast<float>(to_linear(color.b)), static_cast<float>(color.a)};
      if (!material.texture.empty()) {
        item.picture = textures.texture(material);
        if (item.picture == nullptr) return fail(textures.problem(), shape.name);
      } else if (shape.type == ShapeType::plane && !has_looks(material)) {
        item.picture = floor_grid();
      }
      measure(item, model);
      items.push_back(std::move(item));
    }
  }
  return items;
}

std::vector<Placement> place_items(const std::vector<Item>& items, const std::vector<Pose>& poses) {
  std::vector<Placement> out;
  out.reserve(items.size());
  for (const Item& item : items) {
    const Pose& X_WB = poses[static_cast<std::size_t>(item.body)];
    Placement place;
    place.R_WS = (X_WB.q * item.X_BS.q).normalized().toRotationMatrix();
    place.p_WS = X_WB * item.X_BS.p;
    place.middle = place.p_WS + place.R_WS * item.middle;
    out.push_back(place);
  }
  return out;
}

}  // namespace cogrsim::osmesa
