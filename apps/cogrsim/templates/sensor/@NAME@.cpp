// @NAME@: an ultrasonic range finder, which measures the distance to the nearest surface in its
// cone.
//
// A sensor computes an ideal reading from the model and the frame, never from the engine, so that
// it is the same on every backend and can be recomputed from a recording. The scene sets rate,
// noise and dropouts: <sensor plugin="@NAME@" rate="50 Hz" noise="normal(0, 5 mm)">.
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
  // Called once before the first reading. The parameters are complete and within their ranges.
  // Return an error of the scene with fail("…"), which states the problem and what was expected.
  cogrsim::Result<> configure(const cogrsim::SceneModel&, const cogrsim::SensorModel& sensor,
                              const cogrsim::Parameters& parameters) override {
    range_ = std::get<double>(parameters.at("range"));
    const double angle = std::get<double>(parameters.at("cone"));
    const auto rays = static_cast<int>(std::get<std::int64_t>(parameters.at("rays")));
    body_ = sensor.body;
    X_BS_ = sensor.X_BS;
    // Distributed evenly over the cross-section of the cone, the first along the axis: successive
    // rays differ by the golden angle, and the radii grow with the root of the index (Vogel's
    // spiral).
    directions_.clear();
    for (int i = 0; i < rays; ++i) {
      const double off = std::tan(0.5 * angle) * std::sqrt(static_cast<double>(i) / rays);
      const double around = i * std::acos(-1.0) * (3.0 - std::sqrt(5.0));
      directions_.push_back(
          cogrsim::Vec3(1.0, off * std::cos(around), off * std::sin(around)).normalized());
    }
    return {};
  }

  // Names and units of the values of a reading. Noise is added to the noisy ones.
  std::vector<cogrsim::Channel> channels() const override {
    return {{"distance", "m", true}, {"echo", "1", false}};
  }

  // Called at the rate in the scene. It needs no engine: rays() has all visible shapes at their
// current poses.
  cogrsim::Result<> read(cogrsim::SensorContext& context, cogrsim::Reading& reading) override {
    cogrsim::Pose X_WS = X_BS_;  // pose of the sensor frame in the world
    ignored_.clear();
    if (body_ != cogrsim::kWorld) {
      X_WS = context.frame().state.poses[static_cast<std::size_t>(body_)] * X_BS_;
      ignored_.push_back(body_);  // the body that carries the sensor is invisible
    }
    rays_.resize(directions_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      rays_[i].origin = X_WS.p;
      rays_[i].direction = X_WS.q * directions_[i];
      rays_[i].max_distance = range_;
    }
    context.rays().cast(rays_, hits_, ignored_);
    double nearest = std::numeric_limits<double>::infinity();
    double echo = 0.0;
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      if (!hits_[i]) continue;
      nearest = std::min(nearest, hits_[i].distance);
      // Cosine of the angle of incidence: a rough model of the reflected sound.
      echo += std::abs(hits_[i].normal.dot(rays_[i].direction)) / static_cast<double>(hits_.size());
    }
    // No surface within the range: infinity, as for the range finders of CogRSim.
    reading.values = {nearest, echo};
    return {};
  }

 private:
  double range_ = 0.0;  // [m]
  int body_ = cogrsim::kWorld;
  cogrsim::Pose X_BS_;
  std::vector<cogrsim::Vec3> directions_;  // unit vectors in the sensor frame; +x is the axis
  // Reused, so that a reading allocates no memory.
  std::vector<int> ignored_;
  std::vector<cogrsim::Ray> rays_;
  std::vector<cogrsim::RayHit> hits_;
};

}  // namespace

COGRSIM_SENSOR(@CLASS@, "@NAME@", version("0.1.0"), author("you"),
               summary("ultrasonic range finder: the nearest surface in a cone"),
               parameter("range", 4.0, "m", "farther surfaces are not detected").range(0.01, 100.0),
               parameter("cone", 0.5, "rad", "full opening angle").range(0.0, 3.0),
               parameter("rays", 16, "number of rays that sample the cone").range(1, 1000))
