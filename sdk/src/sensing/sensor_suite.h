// All sensors of a run: their sensor models, timers, noise and latest readings. A simulation
// applies them to its own frames and a recording to the recorded frames; equal frames give equal
// readings.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/random.h"
#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"
#include "core/rate_timer.h"

namespace cogrsim {

/// State of a sensor between two readings. A run that continues with this state gives the same
/// readings.
struct SensorMemory {
  RateTimer timer;
  bool enabled = true;
  bool complained = false;  ///< its last measurement failed, and the error was reported
  std::uint64_t random = 0;
  std::vector<double> walk;
  Reading reading;                ///< the latest one delivered
  std::deque<Reading> in_flight;  ///< measured but not delivered yet, by time
};

/// A failed measurement of a sensor.
struct SensorFault {
  int sensor = -1;  ///< index into SceneModel::sensors
  Error error;
};

/// The sensors of a run. Not thread-safe.
class SensorSuite {
 public:
  SensorSuite() = default;
  ~SensorSuite() { clear(); }
  SensorSuite(const SensorSuite&) = delete;
  SensorSuite& operator=(const SensorSuite&) = delete;

  /// Creates and configures the sensors of `model` from index `first` on; existing ones before
  /// `first` are unchanged, the others are destroyed. The random streams depend on `seed` and the
  /// name of the sensor. Errors, with the source location of the sensor: an unknown type (codes of
  /// the loader), or a configuration that the sensor rejects (its own code or CG0906), or a latency for
  /// which there is no memory with steps of `step` [s] (CG0716; of plugins alone, whose number of values
  /// is not known before).
  std::vector<Diagnostic> build(const SceneModelPtr& model, std::uint64_t seed,
                                PluginLoader& loader, double step, std::size_t first = 0);
  /// Likewise of those that there are, when the step changes.
  std::optional<Error> unusable_latency(const SceneModel& model, double step) const;
  /// Destroys the sensors from index `count` on.
  void cut(std::size_t count);
  void clear() { cut(0); }
  std::size_t size() const { return slots_.size(); }

  /// Delivers the readings whose latency has passed, determines the sensors that are due at `time` [s] and returns the frame contents that they
  /// need, or nullopt if none is due. `dt` is the duration of the next step [s]. Must be called
  /// once in every step, followed by read(); the timers of disabled sensors advance, too.
  std::optional<FrameContents> begin(double time, double dt);
  /// Applies the sensors that are due to context.frame() and adds their noise. The first reading of a
  /// sensor is delivered at once, as it has been at rest before the start. Returns the failed
  /// measurements; consecutive failures of a sensor are returned only once.
  std::vector<SensorFault> read(SensorContext& context);

  const Reading& reading(std::size_t sensor) const { return slots_[sensor].memory.reading; }
  const std::vector<Channel>& channels(std::size_t sensor) const {
    return *slots_[sensor].channels;
  }
  /// The channels of all sensors, as in Frame::channels.
  std::shared_ptr<const SensorChannels> channels() const;
  /// The latest readings of all sensors, as in Frame::readings.
  void copy_readings(std::vector<Reading>& out) const;

  void enable(std::size_t sensor, bool on);
  /// Switches off the sensor of a removed element permanently and frees its memory, including
  /// channels and values. Its index remains in use.
  void retire(std::size_t sensor);
  bool enabled(std::size_t sensor) const { return slots_[sensor].memory.enabled; }
  /// The frame contents that the enabled sensors need.
  FrameContents needs() const;
  /// Whether an enabled sensor needs accelerations, which require the twists of the previous step.
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
    double latency = 0.0;
    RandomStream random{0, ""};
    SensorMemory memory;  ///< `random` is current only in save()
  };

  /// Crash-report scope for a call of a sensor.
  static PluginCall calling(const Slot& slot, const char* doing, double time);
  static void take_down(Slot& slot);
  std::vector<Diagnostic> make(const SceneModel& model, std::size_t index, PluginLoader& loader,
                               double step, Slot& slot) const;
  static std::optional<Error> unusable_latency(const SensorModel& description, double step,
                                               const Slot& slot);

  std::vector<Slot> slots_;
  mutable std::shared_ptr<const SensorChannels> channels_;  ///< of all slots; nullptr: not built
  std::vector<std::size_t> due_;
  double now_ = 0.0;
};

/// Mean accelerations over the last step of duration `dt` [s], as differences of twists (one entry
/// per entry of `now`). Bodies that did not exist before have zero.
void mean_accelerations(const std::vector<Twist>& before, const std::vector<Twist>& now, double dt,
                        std::vector<Twist>& out);

}  // namespace cogrsim
