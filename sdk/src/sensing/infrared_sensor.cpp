#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/rays/ray_caster.h"
#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Output voltage of a Sharp GP2Y0A21 [V] over the distance d [m]:
///
///     V(d) = (a / (d + b) + c) (1 - exp(-(d / e)^4))
///
/// This is a fit by the authors of CogRSim. The first factor models the triangulation; it is fitted
/// to the typical values and the curve of the data sheet (2.3 V at 10 cm, 1.3 V at 20 cm, 0.74 V at
/// 40 cm, 0.4 V at 80 cm; the error is at most 1.5 % between 10 and 80 cm, where single devices
/// differ by 10 % and more). The second factor is 1 there and models the decrease of the voltage at
/// short distances: it has its maximum of 3.15 V at 6 cm, as in the data sheet, and falls to 0;
/// below 5 cm the curve is only qualitatively correct. Without an object the voltage is c.
double sharp_gp2y0a21(double d) {
  constexpr double a = 0.2903, b = 0.0299, c = 0.0559, e = 0.045;
  if (!(d > 0.0)) return 0.0;
  if (std::isinf(d)) return c;
  return (a / (d + b) + c) * (1.0 - std::exp(-std::pow(d / e, 4)));
}

/// Infrared sensor: distance along +x to the nearest visible surface. With a cone about +x it is
/// the smallest distance of its rays, or the mean over the rays that hit a surface within three
/// times the maximum range. Noise acts on the distance, and the limits are applied afterwards, so
/// that near a limit the reading alternates between valid and out of range as that of a real
/// device.
class Infrared final : public Sensor {
 public:
  Result<> configure(const SceneModel&, const SensorModel& sensor,
                     const Parameters& parameters) override {
    const auto range = range_of(parameters);
    if (!range) return tl::unexpected(range.error());
    least_ = range->first;
    most_ = range->second;
    auto directions = infrared_directions(parameters);
    if (!directions) return tl::unexpected(directions.error());
    directions_ = std::move(*directions);
    mean_ = text(parameters, "reading") == "mean";
    has_volts_ = text(parameters, "response") != "none";
    sensor_ = sensor;
    ignored_.clear();
    if (sensor.body != kWorld && !boolean(parameters, "sees-own-body")) ignored_ = {sensor.body};
    channels_ = {{"distance", "m", true}, {"body", "1", false}};
    if (has_volts_) channels_.push_back({"volts", "V", false});
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  Result<> read(SensorContext& context, Reading& reading) override {
    const Pose X_WS = motion_of(sensor_, context.frame().state).X_WS;
    rays_.resize(directions_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS.p;
      rays_[i].direction = X_WS.q * directions_[i];
      rays_[i].max_distance = kRayLength * most_;
    }
    context.rays().cast(rays_, hits_, ignored_);
    RayHit nearest;
    double sum = 0.0;
    int count = 0;
    for (const RayHit& hit : hits_) {
      if (!hit) continue;
      sum += hit.distance;
      ++count;
      if (hit.distance < nearest.distance) nearest = hit;
    }
    reading.values[0] = mean_ && count > 0 ? sum / count : nearest.distance;
    reading.values[1] = nearest.body;
    finish(reading);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    reading.values[0] = unlimited_;
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    finish(reading);
    return received;
  }

 private:
  // Length of the rays relative to the maximum range; noise never brings farther surfaces into
  // range.
  static constexpr double kRayLength = 3.0;

  void finish(Reading& reading) {
    double& distance = reading.values[0];
    unlimited_ = distance;
    if (has_volts_) reading.values[2] = sharp_gp2y0a21(distance);
    distance = limited(distance, least_, most_);
    if (distance == kInfinity) reading.values[1] = -1.0;
  }

  SensorModel sensor_;
  std::vector<Channel> channels_;
  std::vector<Vec3> directions_;
  std::vector<int> ignored_;
  std::vector<Ray> rays_;
  std::vector<RayHit> hits_;
  double least_ = 0.0, most_ = 0.0;
  double unlimited_ = 0.0;  ///< the distance before the limits are applied
  bool mean_ = false, has_volts_ = false;
};

}  // namespace

// The rays are distributed evenly over the cross-section of the cone on the spiral of Vogel (1979):
// the angle between ray i of n and the axis is sqrt(i/(n-1)) of the half angle, and successive rays
// differ by the golden angle about the axis. The first ray is the axis.
Result<std::vector<Vec3>> infrared_directions(const Parameters& parameters) {
  const double half = 0.5 * number(parameters, "beam");
  const auto count = static_cast<std::size_t>(half > 0.0 ? integer(parameters, "rays") : 1);
  std::vector<Vec3> directions;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  for (std::size_t i = 0; i < count; ++i) {
    const double at = static_cast<double>(i);
    const double off = i == 0 ? 0.0 : half * std::sqrt(at / static_cast<double>(count - 1));
    directions.emplace_back(std::cos(off), std::sin(off) * std::cos(golden * at),
                            std::sin(off) * std::sin(golden * at));
  }
  return directions;
}

PluginDescriptor infrared() {
  return describe<Infrared>(
      "infrared", "distance along +x, the detected body, and the output voltage of a real device",
      {parameter("range", std::vector<double>{0.0, 10.0}, "m", "least and largest distance")
           .range(0.0, kInfinity),
       parameter("beam", 0.0, "rad", "opening angle of its field of view; 0: one ray")
           .range(0.0, kPi),
       parameter("rays", 9, "rays in the cone, one of them along its axis").range(1, 10000),
       parameter("reading", "nearest", "of several rays").one_of({"nearest", "mean"}),
       parameter("response", "none", "device whose output voltage is measured too")
           .one_of({"none", "GP2Y0A21"}),
       parameter("sees-own-body", false, "the body it is mounted on is seen too")});
}

}  // namespace cogrsim::sensor_models
