#include "sensing/delays.h"

#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/sensing/sensor_models.h"

namespace cogrsim {

namespace {

/// Targets of a motor, and values of a sensor: 1.6 MB and 80 MB.
constexpr double kMostTargets = 1e5, kMostValues = 1e7;

/// Numbers of one reading, roughly: it is a bound of memory.
double values_of(const SensorModel& sensor) {
  constexpr double kOther = 16.0;
  if (sensor.type == "camera") {
    const auto found = sensor.parameters.find("resolution");
    const auto* size = found == sensor.parameters.end()
                           ? nullptr
                           : std::get_if<std::vector<double>>(&found->second);
    return size && size->size() == 2 ? std::max(kOther, (*size)[0] * (*size)[1]) : 320.0 * 240.0;
  }
  return std::max(kOther, static_cast<double>(ray_directions(sensor).size()));
}

double rate_of(const SensorModel& sensor, double step) {
  return sensor.rate > 0.0 ? std::min(sensor.rate, 1.0 / step) : 1.0 / step;
}

std::optional<Error> problem(const std::string& what, const char* attribute, double delay,
                             double rate, double size, double most) {
  const double count = delay * rate;
  if (!(delay >= 0.0 && delay <= kLongestDelay))
    return Error(fmt::format("{} has a {} of {} s, which is not from 0 s to {} s", what, attribute,
                             delay, kLongestDelay),
                 "", fmt::format("write for example {}=\"20 ms\"", attribute), "CG0716");
  if (count * size <= most) return std::nullopt;
  return Error(
      fmt::format("{} has a {} of {} s and would keep {:.0f} of its {}, where {:.0f} is the "
                  "limit",
                  what, attribute, delay, count,
                  size > 1.0 ? fmt::format("readings with {:.0f} values each", size) : "targets",
                  most / size),
      "",
      size > 1.0 ? "make it shorter, or give the sensor a lower rate or fewer values"
                 : "make it or the rate of steps smaller",
      "CG0716");
}

}  // namespace

std::optional<Error> unusable_latency(const SensorModel& sensor, double step, double values) {
  if (sensor.latency == 0.0) return std::nullopt;
  return problem("sensor '" + sensor.name + "'", "latency", sensor.latency, rate_of(sensor, step),
                 values, kMostValues);
}

std::vector<UnusableDelay> unusable_delays(const SceneModel& model, double step) {
  std::vector<UnusableDelay> found;
  const double steps = 1.0 / step;
  for (std::size_t i = 0; i < model.motors.size(); ++i) {
    const Motor& motor = model.motors[i];
    if (motor.removed || motor.delay == 0.0) continue;
    if (auto error =
            problem("motor '" + motor.name + "'", "delay", motor.delay, steps, 1.0, kMostTargets))
      found.push_back({true, static_cast<int>(i), std::move(*error)});
  }
  for (std::size_t i = 0; i < model.sensors.size(); ++i) {
    const SensorModel& sensor = model.sensors[i];
    // The rays of a lidar take their time.
    if (sensor.removed || sensor.latency == 0.0) continue;
    if (auto error = unusable_latency(sensor, step, values_of(sensor)))
      found.push_back({false, static_cast<int>(i), std::move(*error)});
  }
  return found;
}

}  // namespace cogrsim
