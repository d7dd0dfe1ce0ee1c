// What controllers and supervisors of a run have in common: start, timing, faults, snapshot part.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/assembly/input.h"
#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/random.h"
#include "cogrsim/physics/frame.h"
#include "control/hosted_controller.h"
#include "core/rate_timer.h"
#include "simulation/events/event_system.h"
#include "simulation/message_log.h"

namespace cogrsim {

/// Timing of the updates of a controller or supervisor.
struct ControllerClock {
  RateTimer timer;
  bool stopped = false;
  double last_time = 0.0;
  std::uint64_t count = 0;

  bool due(const Clock& clock) const { return !stopped && timer.due(clock.time(), clock.dt()); }
  /// The tick of the update that is due; the next one is scheduled.
  Tick tick(const Clock& clock);
};

/// The state of a controller or supervisor that the simulation holds, part of snapshots.
struct HostedState {
  ControllerClock clock;
  std::uint64_t random = 0;
  std::vector<double> outputs;
  std::vector<Event> events;                 ///< of a supervisor: since its last update
  std::vector<ControllerInput> inputs = {};  ///< of a controller
};

/// Fills in the outputs of the controllers and supervisors that their plugins declare.
void name_outputs(SceneModel& model, PluginLoader& loader);

struct LoadedController {
  PluginPtr plugin;
  Parameters parameters;
};

/// Loads the plugin and completes its parameters; errors are appended to `found`.
std::optional<LoadedController> load_controller(const SceneModel& model, PluginLoader& loader,
                                                PluginKind kind, const ControllerModel& description,
                                                std::vector<Diagnostic>& found);

/// Errors in the configuration of a controller.
struct StartOutcome {
  std::vector<std::string> mistakes;   ///< errors that were collected
  std::optional<std::string> failure;  ///< "threw while being configured: …"
};

/// Appends the errors of configure() to `found`.
void report_mistakes(const SceneModel& model, const ControllerModel& description,
                     const std::string& who, const StartOutcome& outcome,
                     std::vector<Diagnostic>& found);

/// Stops a controller or supervisor that failed in an update. Returns whether the run ends.
bool stop_after_fault(const SceneModel& model, const ControllerModel& description,
                      ControllerClock& timing, const std::string& message, MessageLog& log,
                      EventSystem& events);

}  // namespace cogrsim
