// @NAME@: an ultrasonic range finder, which tells how far away the nearest surface in its cone is.
//
// A sensor computes an ideal reading from the model and the frame, never from the engine, so that it
// is the same on every backend and can be computed again from a recording. Rate, noise and dropouts
// are the scene's: <sensor plugin="@NAME@" rate="50 Hz" noise="normal(0, 5 mm)">.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <cogrsim/rays/ray_caster.h>
#include <cogrsim/sensing/sensor.h>

namespace {

class @CLASS@ final : public cogrsim::Sensor {
 public:
  // Once, before the first reading; the parameters are complete and within their ranges. What the
  // scene has wrong is returned with fail("…"): what, and what was expected.
  cogrsim::Result<> configure(const cogrsim::SceneModel&, const cogrsim::SensorModel& sensor,
                              const cogrsim::Parameters& parameters) override {
    range_ = std::get<double>(parameters.at("range"));
    const double angle = std::get<double>(parameters.at("cone"));
    const auto rays = static_cast<int>(std::get<std::int64_t>(parameters.at("rays")));
    body_ = sensor.body;
    X_BS_ = sensor.X_BS;
    // Spread evenly over the cone's cross-section, the first along the axis: the golden angle from
    // one to the next, radii that grow with the root of the number (Vogel's sunflower).
    directions_.clear();
    for (int i = 0; i < rays; ++i) {
      const double off = std::tan(0.5 * angle) * std::sqrt(static_cast<double>(i) / rays);
      const double around = i * std::acos(-1.0) * (3.0 - std::sqrt(5.0));
      directions_.push_back(
          cogrsim::Vec3(1.0, off * std::cos(around), off * std::sin(around)).normalized());
    }
    return {};
  }

  // What the numbers of a reading are. Noise is added to those that are called noisy.
  std::vector<cogrsim::Channel> channels() const override {
    return {{"distance", "m", true}, {"echo", "1", false}};
  }

  // As often as the scene says. Engine-free: rays() knows all visible shapes where they are now.
  cogrsim::Result<> read(cogrsim::Sensing& sensing, cogrsim::Reading& reading) override {
    cogrsim::Pose X_WS = X_BS_;  // the sensor's frame in the world
    ignored_.clear();
    if (body_ != cogrsim::kWorld) {
      X_WS = sensing.frame().state.poses[static_cast<std::size_t>(body_)] * X_BS_;
      ignored_.push_back(body_);  // it does not see what it is mounted on
    }
    rays_.resize(directions_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS.p;
      rays_[i].direction = X_WS.q * directions_[i];
      rays_[i].max_distance = range_;
    }
    sensing.rays().cast(rays_, hits_, ignored_);
    double nearest = std::numeric_limits<double>::infinity();
    double echo = 0.0;
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      if (!hits_[i]) continue;
      nearest = std::min(nearest, hits_[i].distance);
      // How squarely the sound meets the surface: what comes back of it, very roughly.
      echo += std::abs(hits_[i].normal.dot(rays_[i].direction)) / static_cast<double>(hits_.size());
    }
    // Nothing within the range: infinity, as the range finders of CogRSim have it.
    reading.values = {nearest, echo};
    return {};
  }

 private:
  double range_ = 0.0;  // [m]
  int body_ = cogrsim::kWorld;
  cogrsim::Pose X_BS_;
  std::vector<cogrsim::Vec3> directions_;  // unit, in the sensor's frame, which looks along +x
  // Kept so that a reading allocates nothing.
  std::vector<int> ignored_;
  std::vector<cogrsim::Ray> rays_;
  std::vector<cogrsim::RayHit> hits_;
};

}  // namespace

COGRSIM_SENSOR(@CLASS@, "@NAME@", version("0.1.0"), author("you"),
               summary("ultrasonic range finder: the nearest surface in a cone"),
               parameter("range", 4.0, "m", "what is further away is not heard").range(0.01, 100.0),
               parameter("cone", 0.5, "rad", "full angle of what it hears").range(0.0, 3.0),
               parameter("rays", 16, "that sample the cone").range(1, 1000))
