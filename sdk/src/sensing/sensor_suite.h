// All sensors of a run: their instruments, clocks, noise and latest readings. A simulation reads
// them from its own frames, a recording from those it kept: the same frames give the same readings.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/random.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"
#include "simulation/rate_timer.h"

namespace cogrsim {

/// What a sensor carries from one reading to the next; with it, a run goes on as it would have.
struct SensorMemory {
  RateTimer timer;
  bool enabled = true;
  bool complained = false;  ///< its last attempt failed, and the run was told
  std::uint64_t random = 0;
  std::vector<double> walk;
  Reading reading;
};

/// A sensor that could not see.
struct SensorFault {
  int sensor = -1;  ///< SceneModel::sensors
  Error error;
};

class SensorSuite {
 public:
  SensorSuite() = default;
  ~SensorSuite() { clear(); }
  SensorSuite(const SensorSuite&) = delete;
  SensorSuite& operator=(const SensorSuite&) = delete;

  /// Makes and configures the instruments of `model`'s sensors from index `first` on; those before
  /// stay as they are, those behind are thrown away. Streams of noise are keyed by `seed` and the
  /// sensor's name. Errors, at the sensor's place: an unknown type (the loader's codes), CG0906
  /// what the instrument refuses, or a code of its own.
  std::vector<Diagnostic> build(const SceneModelPtr& model, std::uint64_t seed,
                                PluginLoader& loader, std::size_t first = 0);
  /// `count` sensors that only have readings, given by upd_reading(): in a controller's process.
  void imitate(std::size_t count);
  Reading& upd_reading(std::size_t sensor) { return slots_[sensor].memory.reading; }
  /// Throws away the sensors from `count` on.
  void cut(std::size_t count);
  void clear() { cut(0); }
  std::size_t size() const { return slots_.size(); }

  /// What the frame at `time` must contain for the sensors that are due then, empty when none is;
  /// `dt`: length of the coming step [s], both [s]. To be called once for every step, read() after
  /// it: ticks of sensors that are switched off pass too.
  std::optional<FrameContents> begin(double time, double dt);
  /// Reads the sensors that begin() found due from sensing.frame(), and applies their noise.
  /// Returns those that could not see, each once until it sees again.
  std::vector<SensorFault> read(Sensing& sensing);

  const Reading& reading(std::size_t sensor) const { return slots_[sensor].memory.reading; }
  const std::vector<Channel>& channels(std::size_t sensor) const {
    return *slots_[sensor].channels;
  }
  /// The same of all, as in Frame::channels.
  std::shared_ptr<const SensorChannels> channels() const;
  /// The latest readings of all sensors, as in Frame::readings.
  void copy_readings(std::vector<Reading>& out) const;

  void enable(std::size_t sensor, bool on);
  /// Switches off the sensor of what was removed, for good, and frees what it holds, its channels
  /// and values too; its place stays.
  void retire(std::size_t sensor);
  bool enabled(std::size_t sensor) const { return slots_[sensor].memory.enabled; }
  /// What the sensors that are on need of the frames they read.
  FrameContents needs() const;
  /// Whether a sensor that is on needs accelerations: they take the twists of the step before.
  bool wants_accelerations() const;

  std::vector<SensorMemory> save() const;
  /// Entries beyond size() are ignored.
  void restore(const std::vector<SensorMemory>& memories);

 private:
  struct Slot {
    PluginPtr plugin;  ///< keeps the code loaded; empty for built-in ones
    std::string name, type;
    std::unique_ptr<Sensor, void (*)(Sensor*)> sensor{nullptr, nullptr};
    std::shared_ptr<const std::vector<Channel>> channels =
        std::make_shared<const std::vector<Channel>>();
    FrameContents needs;
    std::vector<NoiseTerm> noise;
    RandomStream random{0, ""};
    SensorMemory memory;  ///< `random` is up to date in save() only
  };

  /// To be kept while a sensor is called.
  static PluginCall calling(const Slot& slot, const char* doing, double time);
  static void take_down(Slot& slot);
  std::vector<Diagnostic> make(const SceneModel& model, std::size_t index, PluginLoader& loader,
                               Slot& slot) const;

  std::vector<Slot> slots_;
  mutable std::shared_ptr<const SensorChannels> channels_;  ///< of the slots; nullptr: not gathered
  std::vector<std::size_t> due_;
  double now_ = 0.0;
};

/// Mean accelerations over the last step, `dt` long: differences of twists (nbody of `now`); bodies
/// that were not there before have zero.
void mean_accelerations(const std::vector<Twist>& before, const std::vector<Twist>& now, double dt,
                        std::vector<Twist>& out);

}  // namespace cogrsim
