// Sensors: computed from SceneModel and Frame, never by the physics engine, so that a reading is the
// same on every backend for the same state, and can be computed again from a recording.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/parameter.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

class RandomStream;

/// One number of a reading.
struct Channel {
  std::string name;  ///< "position"
  std::string unit;  ///< "rad"
  bool noisy = true;  ///< the scene's noise terms apply to it
};

/// The ideal instrument: what would be read without noise. Noise, rate and on/off are the
/// simulation's work. One object per sensor in the scene.
class Sensor {
 public:
  virtual ~Sensor() = default;

  /// Once, before the first reading. `parameters` are complete (defaults filled in).
  /// Errors: what the sensor needs is not there (an encoder without a joint).
  virtual Result<> configure(const SceneModel& model, const SensorModel& sensor,
                             const Parameters& parameters) = 0;

  /// Meaning of the values, in order; fixed after configure().
  virtual std::vector<Channel> channels() const = 0;

  /// What the frames it reads must contain.
  virtual FrameContents needs() const { return {}; }

  /// Reads `frame` into `values`, channels() long. A value that cannot be had is NaN.
  virtual void read(const Frame& frame, std::vector<double>& values) = 0;
};

/// Factory table of a sensor plugin.
struct SensorEntry {
  Sensor* (*create)();
  void (*destroy)(Sensor*);
};

/// The sensors of the SDK itself: "encoder", "pose", "imu"; nullptr for any other type.
COGRSIM_API const SensorEntry* built_in_sensor(const std::string& type);

/// Their names, parameters and summaries, as a plugin would declare them.
COGRSIM_API std::vector<PluginDescriptor> built_in_sensors();

/// Applies the noise of a sensor to the noisy channels of `values`, term by term in order, drawing
/// from `random`.
/// Returns false when the reading dropped out. `walk` (same length as values, zeros at first)
/// carries the bias walk; `period` is the time since the reading before [s].
COGRSIM_API bool apply_noise(const std::vector<NoiseTerm>& noise,
                             const std::vector<Channel>& channels, double period,
                             RandomStream& random, std::vector<double>& walk,
                             std::vector<double>& values);

}  // namespace cogrsim

/// COGRSIM_SENSOR(Reflectance, "reflectance", version("1.0.0"), parameter("elements", 8, "…"))
#define COGRSIM_SENSOR(Class, name, ...)                                                       \
  namespace {                                                                                  \
  const ::cogrsim::SensorEntry cogrsim_entry = {                                               \
      []() -> ::cogrsim::Sensor* { return new Class; },                                        \
      [](::cogrsim::Sensor* sensor) { delete sensor; }};                                       \
  }                                                                                            \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, name, &cogrsim_entry, ##__VA_ARGS__)
