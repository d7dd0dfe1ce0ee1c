#include "cogrsim/sensing/sensor_rays.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/sensing/sensor_models.h"

namespace cogrsim {

std::vector<SensorRay> sensor_rays(const Frame& frame) {
  std::vector<SensorRay> out;
  const std::vector<SensorModel>& sensors = frame.model->sensors;
  const auto ranging = [](const SensorModel& s) {
    return !s.removed && (s.type == "infrared" || s.type == "lidar");
  };
  const bool some_shown = std::any_of(sensors.begin(), sensors.end(),
                                      [&](const SensorModel& s) { return ranging(s) && s.show; });
  for (std::size_t i = 0; i < sensors.size() && i < frame.readings.size(); ++i) {
    const SensorModel& sensor = sensors[i];
    const Reading& reading = frame.readings[i];
    if (!ranging(sensor) || (some_shown && !sensor.show)) continue;
    if (!reading.valid || reading.values.empty()) continue;
    std::vector<Vec3> directions;
    if (sensor.type == "infrared") {
      directions = {Vec3::UnitX()};  // a cone has one distance, drawn along its axis
    } else {
      directions = ray_directions(sensor);
    }
    const RangeLimits limits = range_limits(sensor);
    const Pose X_WS = reading.pose.value_or(sensor_pose(sensor, frame.state));
    for (std::size_t k = 0; k < directions.size() && k < reading.values.size(); ++k) {
      const double distance = reading.values[k];  // -inf: below the minimum range, inf: no hit
      if (std::isnan(distance)) continue;
      SensorRay ray;
      ray.sensor = static_cast<int>(i);
      ray.from = X_WS.p;
      ray.hit = distance < std::numeric_limits<double>::infinity();
      ray.to = X_WS * Vec3(std::clamp(distance, limits.least, limits.most) * directions[k]);
      out.push_back(ray);
    }
  }
  return out;
}

}  // namespace cogrsim
