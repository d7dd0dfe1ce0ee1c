#include "cogrsim/rendering/looks.h"

#include <iterator>

namespace cogrsim {

namespace {

constexpr Color kGround{0.89, 0.89, 0.875, 1.0}, kFixed{0.71, 0.69, 0.66, 1.0};
// Colours of equal lightness.
constexpr Color kPalette[] = {{0.42, 0.58, 0.74, 1.0}, {0.80, 0.53, 0.41, 1.0},
                              {0.52, 0.67, 0.50, 1.0}, {0.80, 0.69, 0.42, 1.0},
                              {0.63, 0.54, 0.71, 1.0}, {0.42, 0.67, 0.66, 1.0},
                              {0.77, 0.54, 0.60, 1.0}, {0.56, 0.60, 0.67, 1.0}};

}  // namespace

bool has_looks(const Material& material) {
  const Color none, &c = material.color;
  return !material.texture.empty() || c.r != none.r || c.g != none.g || c.b != none.b ||
         c.a != none.a;
}

Color shown_color(const SceneModel& model, int body, const Shape& shape) {
  const Material& material = model.materials[shape.material];
  if (has_looks(material)) return material.color;
  if (shape.type == ShapeType::plane || shape.type == ShapeType::heightmap) return kGround;
  if (model.bodies[body].kind == BodyKind::static_body) return kFixed;
  return kPalette[static_cast<std::size_t>(body) % std::size(kPalette)];
}

}  // namespace cogrsim
