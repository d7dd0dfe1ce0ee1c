// Common functions of the built-in sensors.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/constants.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim::sensor_models {

/// Pose and twist of the sensor frame S in the world.
struct SensorMotion {
  Pose X_WS;
  Twist V_WS;
  Vec3 arm = Vec3::Zero();  ///< from the body origin to the origin of S, in world axes [m]
};
SensorMotion motion_of(const SensorModel& sensor, const WorldState& state);

inline void put(std::vector<double>& values, std::size_t at, const Vec3& v) {
  for (int i = 0; i < 3; ++i) values[at + static_cast<std::size_t>(i)] = v[i];
}

/// Clamps values[from .. to) to +-limit; a limit of 0 means no limit.
void saturate(std::vector<double>& values, std::size_t from, std::size_t to, double limit);

inline double number(const Parameters& parameters, const char* name) {
  return std::get<double>(parameters.at(name));
}
inline std::int64_t integer(const Parameters& parameters, const char* name) {
  return std::get<std::int64_t>(parameters.at(name));
}
inline bool boolean(const Parameters& parameters, const char* name) {
  return std::get<bool>(parameters.at(name));
}
inline const std::string& text(const Parameters& parameters, const char* name) {
  return std::get<std::string>(parameters.at(name));
}
inline const std::vector<double>& list(const Parameters& parameters, const char* name) {
  return std::get<std::vector<double>>(parameters.at(name));
}

/// The two entries of parameter `range`. Errors: they are not two finite numbers with
/// 0 <= least < most.
Result<std::pair<double, double>> range_of(const Parameters& parameters);

/// The reading for a distance, as in REP 117 of ROS: -infinity below the minimum range, +infinity
/// beyond the maximum range.
double limited(double distance, double least, double most);

template <class Type>
PluginDescriptor describe(const char* name, const char* summary, ParameterTable parameters = {}) {
  static constexpr SensorEntry kEntry = {[]() -> Sensor* { return new Type; },
                                         [](Sensor* sensor) { delete sensor; }};
  PluginDescriptor d;
  d.kind = PluginKind::sensor;
  d.name = name;
  d.version = "1.0.0";
  d.author = "CogRSim";
  d.summary = summary;
  d.parameters = std::move(parameters);
  d.factory = &kEntry;
  return d;
}

// Each is defined in the file of its sensor.
PluginDescriptor camera();
PluginDescriptor contact();
PluginDescriptor encoder();
PluginDescriptor force_torque();
PluginDescriptor imu();
PluginDescriptor infrared();
PluginDescriptor lidar();
PluginDescriptor pose();

// Functions of single sensor models that other files need; `parameters` must be complete.
Result<std::vector<Vec3>> infrared_directions(const Parameters& parameters);
Result<std::vector<Vec3>> lidar_directions(const Parameters& parameters);
Result<RenderRequest> camera_settings(const Parameters& parameters);
/// Whether the camera is inside a visible shape of the body that carries it.
bool in_own_body(const SceneModel& model, const SensorModel& sensor);

}  // namespace cogrsim::sensor_models
