#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/rays/ray_caster.h"
#include "sensing/sensor_model.h"

namespace cogrsim::sensor_models {

namespace {

/// Maximum number of rays of a reading.
constexpr std::int64_t kMaxRays = 1'000'000;

/// Lidar: distances in many directions, in `rings` levels with the lowest first, each with `rays`
/// directions from right to left (counter-clockwise seen from above). All rays of a reading measure
/// the same frame; the skew of a rotating scanner is not modelled. Noise acts on the distances, and
/// the limits are applied afterwards.
class Lidar final : public Sensor {
 public:
  Result<> configure(const SceneModel&, const SensorModel& sensor,
                     const Parameters& parameters) override {
    const auto range = range_of(parameters);
    if (!range) return tl::unexpected(range.error());
    least_ = range->first;
    most_ = range->second;
    auto directions = lidar_directions(parameters);
    if (!directions) return tl::unexpected(directions.error());
    directions_ = std::move(*directions);
    has_bodies_ = boolean(parameters, "bodies");
    sensor_ = sensor;
    ignored_.clear();
    if (sensor.body != kWorld && !boolean(parameters, "sees-own-body")) ignored_ = {sensor.body};
    channels_.clear();
    const auto rings = static_cast<std::size_t>(integer(parameters, "rings"));
    const std::size_t per_ring = directions_.size() / rings;
    for (const char* what : {"d", "body"}) {
      if (!has_bodies_ && *what == 'b') break;
      for (std::size_t i = 0; i < directions_.size(); ++i) {
        std::string name = what;
        if (rings > 1) name += std::to_string(i / per_ring) + "_";
        name += std::to_string(i % per_ring);
        channels_.push_back({std::move(name), *what == 'd' ? "m" : "1", *what == 'd'});
      }
    }
    return {};
  }
  std::vector<Channel> channels() const override { return channels_; }
  Result<> read(SensorContext& context, Reading& reading) override {
    const Pose X_WS = motion_of(sensor_, context.frame().state).X_WS;
    rays_.resize(directions_.size());
    const Mat3 R_WS = X_WS.q.toRotationMatrix();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS.p;
      rays_[i].direction = R_WS * directions_[i];
      rays_[i].max_distance = kRayLength * most_;
    }
    context.rays().cast(rays_, hits_, ignored_);
    unlimited_.resize(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      unlimited_[i] = hits_[i].distance;
      if (has_bodies_) reading.values[rays_.size() + i] = hits_[i].body;
    }
    finish(reading);
    return {};
  }
  bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
               std::vector<double>& walk, Reading& reading) override {
    if (noise.empty()) return true;
    std::copy(unlimited_.begin(), unlimited_.end(), reading.values.begin());
    const bool received = apply_noise(noise, channels_, period, random, walk, reading.values);
    std::copy_n(reading.values.begin(), unlimited_.size(), unlimited_.begin());
    finish(reading);
    return received;
  }

 private:
  static constexpr double kRayLength = 3.0;  ///< relative to the maximum range, as for an infrared

  void finish(Reading& reading) const {
    for (std::size_t i = 0; i < unlimited_.size(); ++i) {
      reading.values[i] = limited(unlimited_[i], least_, most_);
      if (has_bodies_ && reading.values[i] == kInfinity) {
        reading.values[unlimited_.size() + i] = -1.0;
      }
    }
  }

  SensorModel sensor_;
  std::vector<Channel> channels_;
  std::vector<Vec3> directions_;
  std::vector<int> ignored_;
  std::vector<Ray> rays_;
  std::vector<RayHit> hits_;
  std::vector<double> unlimited_;  ///< distances before the limits are applied
  double least_ = 0.0, most_ = 0.0;
  bool has_bodies_ = false;
};

}  // namespace

// The directions are evenly spaced over the field of view, including both ends. For a full turn the
// two ends coincide, so only one of them is used.
Result<std::vector<Vec3>> lidar_directions(const Parameters& parameters) {
  const std::int64_t rays = integer(parameters, "rays"), rings = integer(parameters, "rings");
  if (rays * rings > kMaxRays) {
    return fail("it has " + std::to_string(rays * rings) + " rays, the limit is " +
                std::to_string(kMaxRays));
  }
  const double fov = number(parameters, "fov"), height = number(parameters, "vertical-fov");
  const bool full = fov > 2.0 * kPi - 1e-9;
  const auto spread = [](std::int64_t i, std::int64_t count, double angle, bool open) {
    if (count == 1) return open ? -0.5 * angle : 0.0;
    return angle * (static_cast<double>(i) / static_cast<double>(open ? count : count - 1) - 0.5);
  };
  std::vector<Vec3> directions;
  directions.reserve(rays * rings);
  for (std::int64_t ring = 0; ring < rings; ++ring) {
    const double up = spread(ring, rings, height, false);
    for (std::int64_t i = 0; i < rays; ++i) {
      const double left = rays == 1 ? 0.0 : spread(i, rays, full ? 2.0 * kPi : fov, full);
      directions.emplace_back(std::cos(up) * std::cos(left), std::cos(up) * std::sin(left),
                              std::sin(up));
    }
  }
  return directions;
}

PluginDescriptor lidar() {
  return describe<Lidar>(
      "lidar", "distances in many directions, in one or several rings",
      {parameter("rays", 360, "directions in a ring").range(1, 1e6),
       parameter("fov", 2.0 * kPi, "rad", "angle a ring spans, centred on +x")
           .range(0.0, 2.0 * kPi + 1e-9),
       parameter("rings", 1, "levels one above the other").range(1, 1e4),
       parameter("vertical-fov", 30.0 * kPi / 180.0, "rad",
                 "angle from the lowest ring to the highest, centred on the x-y plane")
           .range(0.0, kPi),
       parameter("range", std::vector<double>{0.0, 30.0}, "m", "least and largest distance")
           .range(0.0, kInfinity),
       parameter("bodies", false, "measures also which body every ray hits"),
       parameter("sees-own-body", false, "the body it is mounted on is seen too")});
}

}  // namespace cogrsim::sensor_models
