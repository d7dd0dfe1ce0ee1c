// What a model's shapes need to be drawn, and where a frame puts them.
#pragma once

#include <memory>
#include <vector>

#include "cogrsim/model/surface.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim::osmesa {

/// A visible shape.
struct Item {
  int body = 0, shape = 0;
  ShapeType type = ShapeType::box;
  const Shape* source = nullptr;
  Pose X_BS;
  std::array<float, 4> scale{};
  std::array<float, 4> color{};          ///< linear light, and opacity
  std::shared_ptr<const Image> picture;  ///< nullptr: no texture
  // The same of a plane in a picture for people.
  std::array<float, 4> floor_color{};
  std::shared_ptr<const Image> floor_picture;
  Vec3 middle = Vec3::Zero();    ///< of a sphere around it, in S [m]
  double bounding_radius = 0.0;  ///< radius of that sphere [m]
  double curve = 0.0;            ///< radius of what is round [m]; 0: nothing
  bool closed() const { return type <= ShapeType::capsule; }
};

/// Where an item is in one frame.
struct Placement {
  Mat3 R_WS = Mat3::Identity();
  Vec3 p_WS = Vec3::Zero();
  Vec3 middle = Vec3::Zero();  ///< of the sphere around it, world [m]
};

/// Items of what `model` has now. Errors: a texture that went away.
Result<std::vector<Item>> collect_items(const SceneModel& model, TextureStore& textures);

std::vector<Placement> place_items(const std::vector<Item>& items, const std::vector<Pose>& poses);

}  // namespace cogrsim::osmesa
