// The interface of a sensor model. Readings are computed from SceneModel and Frame, never by the
// physics engine. They are therefore the same on every backend for the same state, and can be
// recomputed from a recording.
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

struct RayHit;
class RayCaster;
struct RenderRequest;

/// Access of a sensor to the measured frame. Ray caster and images are computed at the first use
/// and shared by all sensors that measure the same frame. Only valid during Sensor::read().
class SensorContext {
 public:
  virtual ~SensorContext() = default;
  /// The measured frame.
  virtual const Frame& frame() const = 0;
  /// Ray caster for the visible shapes at the poses of the frame.
  virtual const RayCaster& rays() = 0;
  /// Colour of the surface at a hit: colour of the material times its texture, without lighting.
  virtual Color surface_color(const RayHit& hit) = 0;
  /// Renders images of the frame, one per request. Errors: no renderer can be loaded, or those of
  /// the renderer.
  virtual Result<std::vector<Picture>> render(const std::vector<RenderRequest>& requests) = 0;
};

/// Applies the noise terms of a sensor in order to the noisy channels of `values`, with random
/// numbers from `random`. A term affects only the channels of its group. `walk` holds the state of
/// the bias walk (one entry per value, initially zero); `period` is the time since the previous
/// reading [s]. Returns false if the reading dropped out.
COGRSIM_API bool apply_noise(const std::vector<NoiseTerm>& noise,
                             const std::vector<Channel>& channels, double period,
                             RandomStream& random, std::vector<double>& walk,
                             std::vector<double>& values);

/// A sensor model: the ideal measurement without noise. The simulation handles the noise, the rate
/// and the switching on and off. There is one object per sensor in the scene; its calls are made by
/// one thread at a time. Objects of different simulations run in parallel, so static data must be
/// thread-safe.
class Sensor {
 public:
  virtual ~Sensor() = default;

  /// Called once before the first reading. `parameters` are complete (defaults are filled in).
  /// Errors: an element that the sensor needs is missing (an encoder without a joint), or a
  /// parameter is invalid.
  virtual Result<> configure(const SceneModel& model, const SensorModel& sensor,
                             const Parameters& parameters) = 0;

  /// Names and units of the values, in order; constant after configure().
  virtual std::vector<Channel> channels() const = 0;

  /// The optional contents of the frame that read() needs.
  virtual FrameContents needs() const { return {}; }

  /// Measures context.frame() and writes the result to `reading`: `values`, with one entry per
  /// channel, and an image or contacts if the sensor has them. An unavailable value is NaN. Errors:
  /// the measurement is not possible; the reading is then not valid and the error is reported once.
  virtual Result<> read(SensorContext& context, Reading& reading) = 0;

  /// Adds the noise of the scene to an ideal reading; false: the reading dropped out. The default
  /// is apply_noise() on the noisy channels. Cameras add noise to the image, and range finders
  /// apply their limits afterwards.
  virtual bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
                       std::vector<double>& walk, Reading& reading) {
    if (noise.empty()) return true;
    return apply_noise(noise, channels(), period, random, walk, reading.values);
  }
};

/// Factory table of a sensor plugin, defined by COGRSIM_SENSOR.
struct SensorEntry {
  Sensor* (*create)();
  void (*destroy)(Sensor*);
};

/// Factory of a built-in sensor: "camera", "contact", "encoder", "force-torque", "imu", "infrared",
/// "lidar" or "pose"; nullptr for any other type. docs/guide/sensors.md describes the models.
COGRSIM_API const SensorEntry* built_in_sensor(const std::string& type);

/// Names, parameters and summaries of the built-in sensors, as a plugin declares them.
COGRSIM_API std::vector<PluginDescriptor> built_in_sensors();

}  // namespace cogrsim

/// COGRSIM_SENSOR(Reflectance, "reflectance", version("1.0.0"), parameter("elements", 8, "…"))
#define COGRSIM_SENSOR(Class, name, ...)                                                           \
  namespace {                                                                                      \
  const ::cogrsim::SensorEntry cogrsim_entry = {[]() -> ::cogrsim::Sensor* { return new Class; },  \
                                                [](::cogrsim::Sensor* sensor) { delete sensor; }}; \
  }                                                                                                \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, name, &cogrsim_entry, ##__VA_ARGS__)
