// The table of the built-in sensors, and their common functions.
#include <algorithm>
#include <cmath>

#include "cogrsim/sensing/sensor_models.h"
#include "sensing/sensor_model.h"

namespace cogrsim {

namespace sensor_models {

SensorMotion motion_of(const SensorModel& sensor, const WorldState& state) {
  SensorMotion motion;
  if (sensor.body == kWorld) {
    motion.X_WS = sensor.X_BS;
    return motion;
  }
  const auto body = static_cast<std::size_t>(sensor.body);
  const Pose& X_WB = state.poses[body];
  motion.X_WS = X_WB * sensor.X_BS;
  motion.arm = X_WB.q * sensor.X_BS.p;
  motion.V_WS.linear = state.twists[body].at(motion.arm);
  motion.V_WS.angular = state.twists[body].angular;
  return motion;
}

void saturate(std::vector<double>& values, std::size_t from, std::size_t to, double limit) {
  if (limit <= 0.0) return;
  for (std::size_t i = from; i < to; ++i) values[i] = std::clamp(values[i], -limit, limit);
}

Result<std::pair<double, double>> range_of(const Parameters& parameters) {
  const std::vector<double>& range = list(parameters, "range");
  if (range.size() != 2 || !(range[0] >= 0.0) || !(range[0] < range[1]) ||
      !std::isfinite(range[1])) {
    return fail("the range takes two distances, the first at least 0 and below the second", "",
                "write for example range=\"2 .. 80 cm\"");
  }
  return std::make_pair(range[0], range[1]);
}

double limited(double distance, double least, double most) {
  if (distance < least) return -kInfinity;
  return distance > most ? kInfinity : distance;
}

namespace {

const std::vector<PluginDescriptor>& table() {
  static const std::vector<PluginDescriptor> all = {camera(), contact(),  encoder(), force_torque(),
                                                    imu(),    infrared(), lidar(),   pose()};
  return all;
}

/// The complete parameters of a built-in sensor, including defaults; empty if they are invalid.
std::optional<Parameters> completed(const SensorModel& sensor) {
  for (const PluginDescriptor& d : table()) {
    if (d.name != sensor.type) continue;
    if (auto parameters = complete_parameters(d.parameters, sensor.parameters)) return *parameters;
  }
  return std::nullopt;
}

}  // namespace

}  // namespace sensor_models

const SensorEntry* built_in_sensor(const std::string& type) {
  for (const PluginDescriptor& d : sensor_models::table()) {
    if (d.name == type) return static_cast<const SensorEntry*>(d.factory);
  }
  return nullptr;
}

std::vector<PluginDescriptor> built_in_sensors() { return sensor_models::table(); }

Pose sensor_pose(const SensorModel& sensor, const WorldState& state) {
  return sensor_models::motion_of(sensor, state).X_WS;
}

std::vector<Vec3> ray_directions(const SensorModel& sensor) {
  const bool lidar = sensor.type == "lidar";
  if (!lidar && sensor.type != "infrared") return {};
  const auto parameters = sensor_models::completed(sensor);
  if (!parameters) return {};
  auto directions = lidar ? sensor_models::lidar_directions(*parameters)
                          : sensor_models::infrared_directions(*parameters);
  return directions ? std::move(*directions) : std::vector<Vec3>{};
}

RangeLimits range_limits(const SensorModel& sensor) {
  if (sensor.type != "lidar" && sensor.type != "infrared") return {};
  const auto parameters = sensor_models::completed(sensor);
  if (!parameters) return {};
  const auto range = sensor_models::range_of(*parameters);
  return range ? RangeLimits{range->first, range->second} : RangeLimits{};
}

Result<RenderRequest> camera_request(const SceneModel& model, const SensorModel& sensor,
                                     const WorldState& state) {
  if (sensor.type != "camera") return fail("sensor '" + sensor.name + "' is not a camera");
  const PluginDescriptor d = sensor_models::camera();
  const auto parameters = complete_parameters(d.parameters, sensor.parameters);
  if (!parameters) return tl::unexpected(parameters.error());
  auto request = sensor_models::camera_settings(*parameters);
  if (!request) return request;
  request->camera.X_WC = sensor_pose(sensor, state);
  const bool sees_own = std::get<bool>(parameters->at("sees-own-body"));
  if (sensor.body != kWorld && (!sees_own || sensor_models::in_own_body(model, sensor))) {
    request->hidden_bodies = {sensor.body};
  }
  return request;
}

}  // namespace cogrsim
