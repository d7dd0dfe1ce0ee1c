#include <algorithm>
#include <cmath>

#include "cogrsim/rays/ray_caster.h"
#include "sensing/instrument.h"

namespace cogrsim::instruments {

namespace {

/// Output voltage of a Sharp GP2Y0A21 [V] over the distance d [m]:
///
///     V(d) = (a / (d + b) + c) (1 - exp(-(d / e)^4))
///
/// Our own fit. The first factor is the triangulation, fitted to the typical figures of the maker's
/// data sheet and its curve (2.3 V at 10 cm, 1.3 V at 20 cm, 0.74 V at 40 cm, 0.4 V at 80 cm; off
/// by 1.5 % at most between 10 and 80 cm, where single devices differ by 10 % and more). The second
/// is 1 there and lets the voltage fold back below: it peaks with 3.15 V at 6 cm, as in the curve
/// of the data sheet, and falls to 0; closer than 5 cm only the sense of it is right. Nothing in
/// sight: c.
double sharp_gp2y0a21(double d) {
  constexpr double a = 0.2903, b = 0.0299, c = 0.0559, e = 0.045;
  if (!(d > 0.0)) return 0.0;
  if (std::isinf(d)) return c;
  return (a / (d + b) + c) * (1.0 - std::exp(-std::pow(d / e, 4)));
}

/// Distance along +x to the nearest visible surface, or over a cone about +x: the nearest of its
/// rays, or the mean of those that meet something within three times the largest distance. Noise is
/// on the distance; the limits are applied to what comes out of it, so that near a limit noise
/// makes the reading come and go as that of a real device does.
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
  Result<> read(Sensing& sensing, Reading& reading) override {
    const Pose X_WS = motion_of(sensor_, sensing.frame().state).X_WS;
    rays_.resize(directions_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS.p;
      rays_[i].direction = X_WS.q * directions_[i];
      rays_[i].max_distance = kReach * most_;
    }
    sensing.rays().cast(rays_, hits_, ignored_);
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
    reading.values[0] = seen_;
    const bool heard = apply_noise(noise, channels_, period, random, walk, reading.values);
    finish(reading);
    return heard;
  }

 private:
  // Beyond this times its largest distance nothing is looked for: no noise brings it back in.
  static constexpr double kReach = 3.0;

  void finish(Reading& reading) {
    double& distance = reading.values[0];
    seen_ = distance;
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
  double seen_ = 0.0;  ///< the distance before the limits
  bool mean_ = false, has_volts_ = false;
};

}  // namespace

// Over the cross-section of the cone evenly, on Vogel's spiral (1979): ray i of n lies
// sqrt(i/(n-1)) of the half angle off the axis, each a golden angle further round. The first is the
// axis.
Result<std::vector<Vec3>> infrared_directions(const Parameters& parameters) {
  const double half = 0.5 * number(parameters, "beam");
  const auto count = static_cast<std::size_t>(half > 0.0 ? integer(parameters, "rays") : 1);
  std::vector<Vec3> directions;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
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
      "infrared", "distance along +x, the body there, and a real device's volts",
      {parameter("range", std::vector<double>{0.0, 10.0}, "m", "least and largest distance")
           .range(0.0, kInfinity),
       parameter("beam", 0.0, "rad", "opening angle of the cone it looks in; 0: one ray")
           .range(0.0, M_PI),
       parameter("rays", 9, "rays in the cone, one of them along its axis").range(1, 10000),
       parameter("reading", "nearest", "of several rays").one_of({"nearest", "mean"}),
       parameter("response", "none", "device whose volts are told too")
           .one_of({"none", "GP2Y0A21"}),
       parameter("sees-own-body", false, "the body it is mounted on is seen too")});
}

}  // namespace cogrsim::instruments
