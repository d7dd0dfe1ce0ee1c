#include "lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "look.h"
#include "srgb.h"

namespace cogrsim::osmesa {

namespace {

// For cameras of the scene: what no light reaches is about a quarter as bright to the eye's measure
// as what is lit. It differs by direction, so that no two faces of a box in the shade are alike.
constexpr double kAmbientMiddle = 0.19;

constexpr double kLampNear = 0.02;  // nothing nearer casts a lamp's shadow [m]

/// Rows: two directions across `along`, and itself.
Mat3 axes_around(const Vec3& along) {
  const Vec3 other = std::abs(along.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  Mat3 rows;
  rows.row(0) = other.cross(along).normalized();
  rows.row(1) = along.cross(rows.row(0).transpose());
  rows.row(2) = along;
  return rows;
}

double lamp_far(const Light& light, const CasterBounds& bounds) {
  return std::max((bounds.middle - light.position).norm() + bounds.radius, 2.0 * kLampNear);
}

/// What a map of a spot must span: tangent of the half angle, kept below a right angle.
double spot_tangent(const Light& light) { return std::tan(std::min(light.cone * 1.02, 1.45)); }

Eigen::Matrix4d translation(const Vec3& by) {
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topRightCorner<3, 1>() = by;
  return out;
}

}  // namespace

std::vector<Light> lights_of(const SceneModel& model) {
  std::vector<Light> out;
  int layer = 0;
  for (const LightModel& source : model.lights) {
    if (static_cast<int>(out.size()) == kMaxLights) break;
    Light light;
    light.type = source.type;
    light.position = source.X_WL.p;
    light.direction = source.X_WL.q * Vec3::UnitX();
    light.color =
        kLightShare * source.intensity *
        Vec3(to_linear(source.color.r), to_linear(source.color.g), to_linear(source.color.b));
    light.cone = source.cone;
    light.shadows = source.shadows && layer + light.layer_count() <= kMaxShadowLayers;
    if (light.shadows) {
      light.layer = layer;
      layer += light.layer_count();
    }
    out.push_back(light);
  }
  if (out.empty()) {
    Light sun;
    sun.direction = kKey.normalized();
    sun.color = kLightShare * Vec3::Ones();
    sun.shadows = true;
    out.push_back(sun);
    Light fill;
    fill.direction = kFill.normalized();
    fill.color = kFillShare * Vec3::Ones();
    out.push_back(fill);
  }
  return out;
}

std::string letters_of(const std::vector<Light>& lights, bool shadows) {
  std::string out;
  for (const Light& light : lights) {
    const char letter = "dps"[static_cast<std::size_t>(light.type)];
    out += light.shadows && shadows ? static_cast<char>(letter - 'a' + 'A') : letter;
  }
  return out;
}

DepthLaw depth_law(const Light& light, const CasterBounds& bounds) {
  const double far = lamp_far(light, bounds);
  return {far / (far - kLampNear), far * kLampNear / (far - kLampNear)};
}

std::vector<ShadowMap> shadow_maps(const Light& light, const CasterBounds& bounds) {
  std::vector<ShadowMap> out;
  if (light.type == LightModel::Type::directional) {
    ShadowMap map;
    map.origin = bounds.middle;
    map.clip.setIdentity();
    map.clip.topLeftCorner<3, 3>() = axes_around(light.direction) / std::max(bounds.radius, 1e-6);
    map.clip.row(2) *= 0.5;
    map.clip(2, 3) = 0.5;
    out.push_back(map);
    return out;
  }
  const DepthLaw depth = depth_law(light, bounds);
  const auto add = [&](const Eigen::RowVector3d& across, const Eigen::RowVector3d& up,
                       const Eigen::RowVector3d& along) {
    ShadowMap map;
    map.origin = light.position;
    map.clip.setZero();
    map.clip.row(0).head<3>() = across;
    map.clip.row(1).head<3>() = up;
    map.clip.row(2).head<3>() = depth.x * along;
    map.clip(2, 3) = -depth.y;
    map.clip.row(3).head<3>() = along;
    out.push_back(map);
  };
  if (light.type == LightModel::Type::spot) {
    const Mat3 axes = axes_around(light.direction);
    const double tangent = spot_tangent(light);
    add(axes.row(0) / tangent, axes.row(1) / tangent, axes.row(2));
    return out;
  }
  const Mat3 unit = Mat3::Identity();
  constexpr int kAcross[] = {1, 0, 0}, kUp[] = {2, 2, 1};  // as shadow_around() has them
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      add(unit.row(kAcross[axis]), unit.row(kUp[axis]), side * unit.row(axis));
    }
  }
  return out;
}

void set_lights(Program& program, const std::vector<Light>& lights, bool shadows,
                const CasterBounds& bounds, const View& view, int map_size, Look look) {
  const bool plain = look == Look::plain;
  const Vec3 middle =
      plain ? Vec3::Constant(kAmbientMiddle) : Vec3(0.5 * (kSkyLight + kGroundLight));
  program.set("u_ambient_middle", Eigen::Vector3f(middle.cast<float>()));
  program.set(
      "u_ambient_toward",
      Eigen::Vector3f((plain ? kAmbientToward : kAmbientToward.normalized()).cast<float>()));
  if (!plain)
    program.set("u_ambient_half",
                Eigen::Vector3f((0.5 * (kSkyLight - kGroundLight)).cast<float>()));
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Light& light = lights[i];
    const auto name = [i](const char* what) { return fmt::format("u_light{}_{}", i, what); };
    const bool directional = light.type == LightModel::Type::directional;
    program.set(name("color").c_str(), Eigen::Vector3f(light.color.cast<float>()));
    const Vec3 position = directional ? Vec3(-light.direction) : Vec3(light.position - view.origin);
    program.set(name("position").c_str(), Eigen::Vector3f(position.cast<float>()));
    program.set(name("axis").c_str(), Eigen::Vector3f(light.direction.cast<float>()));
    program.set(name("range").c_str(),
                Eigen::Vector4d(1.0 / (kLampRange * kLampRange), std::cos(light.cone),
                                std::cos(kSpotEdge * light.cone), 0.0)
                    .cast<float>()
                    .eval());
    if (!shadows || !light.shadows) continue;
    // A texel seen edge-on is what a surface may be off by; one and a half of it is safe.
    double texel = 2.0 / map_size;
    if (directional) texel *= bounds.radius;
    if (light.type == LightModel::Type::spot) texel *= spot_tangent(light);
    const DepthLaw depth = depth_law(light, bounds);
    program.set(name("shadow").c_str(),
                Eigen::Vector4d(light.layer, 1.5 * texel, depth.x, depth.y).cast<float>().eval());
    if (light.type == LightModel::Type::point) continue;
    const ShadowMap map = shadow_maps(light, bounds).front();
    // Clip space is -1 to 1, a texture's 0 to 1; depth is 0 to 1 in both.
    Eigen::Matrix4d to_texture = Eigen::Matrix4d::Identity();
    to_texture(0, 0) = to_texture(1, 1) = 0.5;
    to_texture(0, 3) = to_texture(1, 3) = 0.5;
    const Eigen::Matrix4d all = to_texture * map.clip * translation(view.origin - map.origin);
    program.set(name("map").c_str(), Eigen::Matrix4f(all.cast<float>()));
  }
}

}  // namespace cogrsim::osmesa
