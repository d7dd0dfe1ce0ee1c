// What the built-in sensors have in common.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/constants.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim::instruments {

/// Pose and twist of the sensor's own frame S in the world.
struct SensorMotion {
  Pose X_WS;
  Twist V_WS;
  Vec3 arm = Vec3::Zero();  ///< from the body's origin to S, world axes [m]
};
SensorMotion motion_of(const SensorModel& sensor, const WorldState& state);

inline void put(std::vector<double>& values, std::size_t at, const Vec3& v) {
  for (int i = 0; i < 3; ++i) values[at + static_cast<std::size_t>(i)] = v[i];
}

/// Keeps values[from .. to) within +-limit; a limit of 0 is none.
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

/// The entries of parameter `range`. Errors: not two numbers, 0 <= least < most, finite.
Result<std::pair<double, double>> range_of(const Parameters& parameters);

/// What is read of a distance, as ROS has it for ranges (REP 117): -infinity below the least, where
/// the instrument is blind, +infinity beyond the most, where it sees nothing.
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

// One in each sensor's own file.
PluginDescriptor camera();
PluginDescriptor contact();
PluginDescriptor encoder();
PluginDescriptor force_torque();
PluginDescriptor imu();
PluginDescriptor infrared();
PluginDescriptor lidar();
PluginDescriptor pose();

// What several files need of one instrument; `parameters` are complete.
Result<std::vector<Vec3>> infrared_directions(const Parameters& parameters);
Result<std::vector<Vec3>> lidar_directions(const Parameters& parameters);
Result<RenderRequest> camera_settings(const Parameters& parameters);
/// Whether the camera is built into a visible shape of the body that carries it.
bool in_own_body(const SceneModel& model, const SensorModel& sensor);

}  // namespace cogrsim::instruments
