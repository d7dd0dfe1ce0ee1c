#include "cogrsim/rendering/looks.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace cogrsim {

namespace {

constexpr Color kGround{0.89, 0.89, 0.875, 1.0}, kFixed{0.71, 0.69, 0.66, 1.0},
    kDarkGround{0.50, 0.51, 0.53, 1.0};
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

Color floor_color(const SceneModel& model, int body, const Shape& plane) {
  const Color own = shown_color(model, body, plane);
  // The difference to the nearest colour of what may stand on it: in the greatest channel, 0 to 1.
  const auto apart = [&](const Color& c) {
    double least = 1.0;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      if (model.bodies[b].removed) continue;
      for (const Shape& shape : model.bodies[b].shapes) {
        if (!shape.visible || shape.type == ShapeType::plane ||
            shape.type == ShapeType::heightmap || !model.materials[shape.material].texture.empty())
          continue;
        const Color other = shown_color(model, static_cast<int>(b), shape);
        least = std::min(least, std::max({std::abs(c.r - other.r), std::abs(c.g - other.g),
                                          std::abs(c.b - other.b)}));
      }
    }
    return least;
  };
  constexpr double kEnough = 0.1;
  if (!model.materials[plane.material].texture.empty() || apart(own) >= kEnough) return own;
  Color best = own;
  double most = 0.0;
  for (const Color& toward : {kGround, kDarkGround}) {
    constexpr double kShare = 0.65;
    const auto mixed = [&](double from, double to) { return from + kShare * (to - from); };
    const Color c{mixed(own.r, toward.r), mixed(own.g, toward.g), mixed(own.b, toward.b), own.a};
    const double distance = apart(c);
    if (distance >= kEnough) return c;
    if (distance > most) {
      most = distance;
      best = c;
    }
  }
  return best;
}

}  // namespace cogrsim
