// The lights of a scene and their shadow maps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "shaders.h"
#include "view.h"

namespace cogrsim::osmesa {

/// One light as it is drawn.
struct Light {
  LightModel::Type type = LightModel::Type::directional;
  Vec3 position = Vec3::Zero();    ///< world [m]
  Vec3 direction = Vec3::UnitX();  ///< it shines in, world
  Vec3 color = Vec3::Ones();       ///< linear light
  double cone = 0.5;
  bool shadows = false;
  int layer = 0;  ///< first of its shadow maps
  int layer_count() const { return type == LightModel::Type::point ? 6 : 1; }
};

/// At most this many lights shine and this many maps are made; the rest of a scene's is left out.
inline constexpr int kMaxLights = 16, kMaxShadowLayers = 24;

/// The scene's lights; a key light and a weak fill if it has none.
std::vector<Light> lights_of(const SceneModel& model);
/// A letter for each, see lit_fragment_shader().
std::string letters_of(const std::vector<Light>& lights, bool shadows);

/// What casts shadows: a sphere around all of it, world.
struct CasterBounds {
  Vec3 middle = Vec3::Zero();
  double radius = 0.0;
};

/// One shadow map: how the world falls on it.
struct ShadowMap {
  Vec3 origin = Vec3::Zero();  ///< positions are taken relative to it, world [m]
  Eigen::Matrix4d clip;        ///< from there to clip space, depth 0 to 1
};

/// Depth for a point light's map is x - y / w.
struct DepthLaw {
  double x = 0.0, y = 0.0;
};
DepthLaw depth_law(const Light& light, const CasterBounds& bounds);
std::vector<ShadowMap> shadow_maps(const Light& light, const CasterBounds& bounds);

/// Sets the uniforms of lit_fragment_shader() for a view.
void set_lights(Program& program, const std::vector<Light>& lights, bool shadows,
                const CasterBounds& bounds, const View& view, int map_size, Look look);

}  // namespace cogrsim::osmesa
