// Sensors: computed from SceneModel and Frame, never by the physics engine, so that a reading is
// the same on every backend for the same state, and can be computed again from a recording.
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

/// What a sensor is given at each reading. What it offers is made when first asked for and shared
/// by all sensors that read the same frame.
class Sensing {
 public:
  virtual ~Sensing() = default;
  virtual const Frame& frame() const = 0;
  /// Visible shapes at the frame's poses.
  virtual const RayCaster& rays() = 0;
  /// Colour of the surface at a hit: the material's, times its texture; unlit.
  virtual Color surface_color(const RayHit& hit) = 0;
  /// Pictures of the frame. Errors: no renderer can be loaded, or the renderer's own.
  virtual Result<std::vector<Picture>> render(const std::vector<RenderRequest>& requests) = 0;
};

/// Applies the noise of a sensor to the noisy channels of `values`, term by term in order, drawing
/// from `random`; a term touches the channels of its group only.
/// Returns false when the reading dropped out. `walk` (same length as values, zeros at first)
/// carries the bias walk; `period` is the time since the reading before [s].
COGRSIM_API bool apply_noise(const std::vector<NoiseTerm>& noise,
                             const std::vector<Channel>& channels, double period,
                             RandomStream& random, std::vector<double>& walk,
                             std::vector<double>& values);

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

  /// Reads sensing.frame() into `reading`: `values`, channels() long, and what else it has. A value
  /// that cannot be had is NaN. Errors: what keeps it from seeing at all; the reading is then not
  /// valid and the run is told, once.
  virtual Result<> read(Sensing& sensing, Reading& reading) = 0;

  /// The scene's noise on an ideal reading; false: it dropped out. The standard way is
  /// apply_noise() on the noisy channels; cameras add theirs to the picture, range finders mind
  /// their limits afterwards.
  virtual bool disturb(const std::vector<NoiseTerm>& noise, double period, RandomStream& random,
                       std::vector<double>& walk, Reading& reading) {
    if (noise.empty()) return true;
    return apply_noise(noise, channels(), period, random, walk, reading.values);
  }
};

/// Factory table of a sensor plugin.
struct SensorEntry {
  Sensor* (*create)();
  void (*destroy)(Sensor*);
};

/// The sensors of the SDK itself: "camera", "contact", "encoder", "force-torque", "imu",
/// "infrared", "lidar", "pose"; nullptr for any other type. Their models: docs/sensors.md.
COGRSIM_API const SensorEntry* built_in_sensor(const std::string& type);

/// Their names, parameters and summaries, as a plugin would declare them.
COGRSIM_API std::vector<PluginDescriptor> built_in_sensors();

}  // namespace cogrsim

/// COGRSIM_SENSOR(Reflectance, "reflectance", version("1.0.0"), parameter("elements", 8, "…"))
#define COGRSIM_SENSOR(Class, name, ...)                                                           \
  namespace {                                                                                      \
  const ::cogrsim::SensorEntry cogrsim_entry = {[]() -> ::cogrsim::Sensor* { return new Class; },  \
                                                [](::cogrsim::Sensor* sensor) { delete sensor; }}; \
  }                                                                                                \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::sensor, name, &cogrsim_entry, ##__VA_ARGS__)
