// Simulation of a scene on a backend: clock, step order, sensors, controllers, supervisors,
// commands.
//
// The order of a step is always:
//   1. commands that were queued since the last step are applied
//   2. sensors that are due measure the last frame
//   3. controllers that are due are updated, then supervisors, each in the order of the file
//   4. motors convert their targets to drives
//   5. World::step(dt)
//   6. the observers receive the new frame
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/assembly/input.h"
#include "cogrsim/control/command.h"
#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

/// Options of a run.
struct SimulationOptions {
  std::string backend;                ///< empty: that of the scene, otherwise "bullet"
  double step = 0.0;                  ///< time step [s], from 1e-9; 0: that of the scene
  std::optional<std::uint64_t> seed;  ///< empty: that of the scene
  double speed = std::numeric_limits<double>::infinity();  ///< see SetSpeed
  Isolation isolation = Isolation::none;  ///< of controllers whose isolation is not set
  /// What is left out of the scene, and of what is added to it: see check_without(). Provenance::left_out
  /// says what that was.
  std::vector<std::string> without;
};

/// Status of a run.
enum class RunStatus {
  running,    ///< not ended
  completed,  ///< reached the requested time
  stopped,    ///< ended by a command, a supervisor or stop()
  fault,      ///< ended by a fault of a controller (`on-fault="end-run"`), or of an engine in
              ///< a process of its own
  diverged    ///< the physics diverged
};
/// "running", "completed", "stopped", "fault", "diverged".
COGRSIM_API const char* to_string(RunStatus status);

/// A message of a run: a fault, a rejected command, or a report of a controller.
struct RunMessage {
  double time = 0.0;  ///< simulated time [s]
  Severity severity = Severity::error;
  std::string source;  ///< name of the robot, controller, command …
  std::string message;
};

/// The state of a run at one step boundary: world, motors, sensor noise and clock. It does not
/// include the internal state of the controllers; see Simulation::restore().
struct SimulationSnapshot;
using SimulationSnapshotPtr = std::shared_ptr<const SimulationSnapshot>;

/// A controller of a run and the process that it runs in; see Simulation::controller_processes().
struct ControllerProcess {
  std::string controller;    ///< dotted name
  std::int64_t process = 0;  ///< id of its own process; 0: it has none, or that has ended
  std::string library;       ///< path of the library that it comes from
};

/// Result of Simulation::reload_controller().
struct Reloaded {
  std::string controller;    ///< dotted name
  std::string plugin;        ///< name of the plugin
  std::string version;       ///< version of the new library
  bool memory_kept = false;  ///< true: it has the state of the old controller; false: it restarted
  std::string note;          ///< why it restarted; empty if the state was transferred
};

/// Handle of an observer, with which it can be removed. Destroying the handle does not remove it.
class COGRSIM_API Observation {
 public:
  struct Slot;
  Observation() = default;
  explicit Observation(std::weak_ptr<Slot> slot) : slot_(std::move(slot)) {}

  /// Removes the observer: from the next frame on it is not called and its frame contents are not
  /// computed. Must be called by the thread that steps the simulation, possibly in the observer
  /// itself. No effect if the observer or the simulation no longer exists.
  void end();

 private:
  std::weak_ptr<Slot> slot_;
};

/// A running simulation. Not thread-safe except where stated: all other calls must be made by one
/// thread at a time. Different simulations may run in different threads.
class COGRSIM_API Simulation {
 public:
  /// Loads the backend and the plugins, checks the capabilities, builds the world and configures
  /// the controllers. Errors: all problems that were found, one Diagnostic each. Warnings are in
  /// messages().
  static tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> create(
      SceneModelPtr scene, const SimulationOptions& options, std::shared_ptr<PluginLoader> loader);
  ~Simulation();

  const Backend& backend() const;
  /// The code that computes each stage of this run, and all options in use.
  const Provenance& provenance() const;
  /// The current scene, including elements that were added or removed during the run.
  const SceneModelPtr& model() const;
  double time() const;               ///< simulated time [s]
  double dt() const;                 ///< current time step [s]
  std::uint64_t step_count() const;  ///< number of steps since the start
  RunStatus status() const;
  const std::vector<RunMessage>& messages() const;

  /// The latest frame with all optional contents.
  FramePtr frame();

  /// Adds an observer, which is called with every new frame by the thread that steps. Observers are
  /// called in the order of their registration and should return quickly.
  using Observer = std::function<void(const FramePtr&)>;
  Observation observe(FrameContents contents, Observer observer);

  /// Steps until `end_time` [s] and returns `completed`; status() is still `running`, and a later
  /// call continues the run. If the run ends earlier, it returns the final status(). If the
  /// simulation is paused and no command is queued, it returns `running` at once. The function
  /// sleeps to limit the speed, see SetSpeed. Dividing a run into several calls does not change the
  /// results.
  RunStatus run_until(double end_time);
  /// Makes one step. If the run has ended or is paused, it only applies commands (including
  /// StepOnce, Resume and Restart).
  RunStatus step();

  /// Queues a command for the next step boundary. Thread-safe.
  void send(Command command);
  /// Ends the run at the next step boundary. Thread-safe and safe in signal handlers.
  void stop() noexcept;
  bool paused() const;

  /// Saves the state of the run; call it between steps.
  SimulationSnapshotPtr save() const;
  /// Restores a saved state. If `restart_controllers` is set, the controllers are created and
  /// configured again; otherwise they continue with their internal state. Errors: the snapshot is
  /// from another scene or backend.
  Result<> restore(const SimulationSnapshotPtr& snapshot, bool restart_controllers = false);

  /// Replaces the library of a running controller by the current file on disk. Must be called
  /// between steps by the thread that steps. `name` is that of the controller, or of an assembly
  /// with exactly one controller. The new controller is configured and gets the state that the old
  /// one returns from save(); motor targets are unchanged. Without such a state it restarts. A
  /// controller that was stopped by a fault runs again. Restarts and controllers that are added
  /// later use the new library, too. Errors, after which nothing has changed: the controller does
  /// not exist; the run has ended; the library cannot be loaded; the parameters of the scene do not
  /// match the new library; its outputs differ; configure() fails; it does not accept the state.
  Result<Reloaded> reload_controller(const std::string& name);

  /// The controllers of the present model, for a debugger. Must be called between steps by the thread
  /// that steps.
  std::vector<ControllerProcess> controller_processes() const;

  /// The controllers that have inputs, with their present values. Must be called between steps by the
  /// thread that steps.
  std::vector<ControllerInputs> controller_inputs() const;

  /// The reading that controllers now get from a sensor, by its index.
  const Reading& reading(int sensor) const;
  /// The channels of a sensor by its index.
  const std::vector<Channel>& channels(int sensor) const;

  struct Impl;

 private:
  friend struct SnapshotAccess;  // snapshot files
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
