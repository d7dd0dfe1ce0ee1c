// A row of reflectance elements that point at the floor, for line followers. See README.md.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "cogrsim/rays/ray_caster.h"
#include "cogrsim/sensing/sensor.h"

namespace reflectance {
namespace {

using cogrsim::Vec3;

/// Linear light of an sRGB value, IEC 61966-2-1.
double to_linear(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

/// Relative luminance with the weights of ITU-R BT.709, 0 to 1.
double luminance(const cogrsim::Color& color) {
  return 0.2126 * to_linear(color.r) + 0.7152 * to_linear(color.g) + 0.0722 * to_linear(color.b);
}

/// A ray of the spot: its offset from the centre as a multiple of the radius, and its weight.
struct SpotRay {
  double y, z, weight;
};

/// Mean over a disc from seven points, exact for polynomials up to degree 5 (Abramowitz and Stegun,
/// formula 25.4.61): the centre with weight 1/4, and six points at sqrt(2/3) of the radius with
/// 1/8.
std::array<SpotRay, 7> spot_rays() {
  std::array<SpotRay, 7> out{};
  out[0] = {0.0, 0.0, 0.25};
  const double radius = std::sqrt(2.0 / 3.0), sixth = std::acos(-1.0) / 3.0;
  for (std::size_t i = 1; i < out.size(); ++i) {
    const double turn = sixth * static_cast<double>(i);
    out[i] = {radius * std::cos(turn), radius * std::sin(turn), 0.125};
  }
  return out;
}

class Reflectance final : public cogrsim::Sensor {
 public:
  cogrsim::Result<> configure(const cogrsim::SceneModel&, const cogrsim::SensorModel& sensor,
                              const cogrsim::Parameters& parameters) override {
    const auto number = [&](const char* name) { return std::get<double>(parameters.at(name)); };
    const auto elements = std::get<std::int64_t>(parameters.at("elements"));
    const double pitch = number("pitch"), spot = number("spot");
    range_ = number("range");
    if (!(range_ > 0.0)) return cogrsim::fail("range must be more than 0 m");
    body_ = sensor.body;
    X_BS_ = sensor.X_BS;
    channels_.clear();
    starts_.clear();
    weights_.clear();
    const std::array<SpotRay, 7> rays = spot_rays();
    per_element_ = spot > 0.0 ? rays.size() : 1;
    for (std::int64_t i = 0; i < elements; ++i) {
      channels_.push_back({"element_" + std::to_string(i + 1), "1", true});
      const double middle =
          pitch * (0.5 * static_cast<double>(elements - 1) - static_cast<double>(i));
      for (std::size_t k = 0; k < per_element_; ++k) {
        starts_.emplace_back(0.0, middle + spot * rays[k].y, spot * rays[k].z);
        weights_.push_back(per_element_ == 1 ? 1.0 : rays[k].weight);
      }
    }
    return {};
  }

  std::vector<cogrsim::Channel> channels() const override { return channels_; }

  cogrsim::Result<> read(cogrsim::SensorContext& context, cogrsim::Reading& reading) override {
    cogrsim::Pose X_WS = X_BS_;
    ignored_.clear();
    if (body_ != cogrsim::kWorld) {
      X_WS = context.frame().state.poses[body_] * X_BS_;
      ignored_.push_back(body_);
    }
    rays_.resize(starts_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS * starts_[i];
      rays_[i].direction = X_WS.q * Vec3::UnitX();
      rays_[i].max_distance = range_;
    }
    context.rays().cast(rays_, hits_, ignored_);
    reading.values.assign(channels_.size(), 0.0);
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      if (!hits_[i]) continue;  // no reflected light
      reading.values[i / per_element_] += weights_[i] * luminance(context.surface_color(hits_[i]));
    }
    return {};
  }

 private:
  int body_ = cogrsim::kWorld;
  cogrsim::Pose X_BS_;
  double range_ = 0.0;           // [m]
  std::size_t per_element_ = 1;  // rays
  std::vector<cogrsim::Channel> channels_;
  std::vector<Vec3> starts_;     // of all rays, in the sensor frame [m]
  std::vector<double> weights_;  // of all rays
  // Reused, so that a reading allocates no memory.
  std::vector<int> ignored_;
  std::vector<cogrsim::Ray> rays_;
  std::vector<cogrsim::RayHit> hits_;
};

}  // namespace
}  // namespace reflectance

COGRSIM_SENSOR(
    reflectance::Reflectance, "reflectance", version("1.0.0"),
    summary("row of reflectance elements for following lines on the floor"),
    parameter("elements", 8, "number of elements, side by side along y").range(1, 64),
    parameter("pitch", 0.0095, "m", "distance between neighbouring elements").range(0.0, 1.0),
    parameter("range", 0.03, "m", "farther surfaces give 0").range(0.0, 10.0),
    parameter("spot", 0.002, "m", "radius of the spot of an element; 0: one point").range(0.0, 1.0))
