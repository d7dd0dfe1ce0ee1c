// Runs a scene on a backend: clock, step order, sensors, controllers, supervisors, commands.
//
// One step, always in this order:
//   1. commands queued since the last step     2. sensors that are due read the last frame
//   3. controllers, then supervisors that are due, in file order
//   4. motors turn targets into drives         5. World::step(dt)
//   6. the new frame goes to the observers
#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/backend.h"
#include "cogrsim/physics/frame.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/sensing/sensor.h"
#include "cogrsim/simulation/command.h"

namespace cogrsim {

struct SimulationOptions {
  std::string backend;                                     ///< empty: the scene's, else "bullet"
  double step = 0.0;                                       ///< [s]; 0: the scene's
  std::optional<std::uint64_t> seed;                       ///< empty: the scene's
  double speed = std::numeric_limits<double>::infinity();  ///< see SetSpeed
  Isolation isolation = Isolation::none;                   ///< of controllers that do not say
};

enum class RunStatus {
  running,    ///< not ended
  completed,  ///< reached the time asked for
  stopped,    ///< by a command, a supervisor or stop()
  fault,      ///< a controller's fault ended it (`on-fault="end-run"`)
  diverged    ///< the physics exploded
};
/// "running", "completed", "stopped", "fault", "diverged".
COGRSIM_API const char* to_string(RunStatus status);

/// A message of a run: a fault, a refused command, what a controller reported.
struct RunMessage {
  double time = 0.0;
  Severity severity = Severity::error;
  std::string source;  ///< robot, controller, command …
  std::string message;
};

/// The whole state of a run at one step boundary: world, motors, sensors' noise, clock.
/// Controllers keep their own memory and are not part of it; see Simulation::restore.
struct SimulationSnapshot;
using SimulationSnapshotPtr = std::shared_ptr<const SimulationSnapshot>;

/// What Simulation::reload_controller() did.
struct Reloaded {
  std::string controller;  ///< dotted name
  std::string plugin;
  std::string version;       ///< of the library that runs now
  bool memory_kept = false;  ///< it goes on with the memory of the one before; else it began anew
  std::string note;          ///< why it began anew; empty when the memory was kept
};

/// An observer of a simulation, by which it is taken off; letting go of this changes nothing.
class COGRSIM_API Observation {
 public:
  struct Watcher;
  Observation() = default;
  explicit Observation(std::weak_ptr<Watcher> watcher) : watcher_(std::move(watcher)) {}

  /// From the next frame on the observer is not called any more and its contents are not made. By
  /// the thread that steps, also while it is called; nothing happens if it or the simulation is gone.
  void end();

 private:
  std::weak_ptr<Watcher> watcher_;
};

class COGRSIM_API Simulation {
 public:
  /// Loads backend and plugins, checks capabilities, builds the world, configures controllers.
  /// Errors: all that were found, one Diagnostic each; advice goes to messages().
  static tl::expected<std::unique_ptr<Simulation>, std::vector<Diagnostic>> create(
      SceneModelPtr scene, const SimulationOptions& options, std::shared_ptr<PluginLoader> loader);
  ~Simulation();

  const Backend& backend() const;
  /// Who computes what in this run, with every option in force.
  const Provenance& provenance() const;
  const SceneModelPtr& model() const;
  double time() const;
  double dt() const;
  std::uint64_t step_count() const;
  RunStatus status() const;
  const std::vector<RunMessage>& messages() const;

  /// The latest frame, with everything a frame can contain.
  FramePtr frame();

  /// Observers see every frame after its step, in order of registration. Keep them short.
  using Observer = std::function<void(const FramePtr&)>;
  Observation observe(FrameContents contents, Observer observer);

  /// Steps until `end_time` [s]: returns `completed`, while status() stays `running` and a later
  /// call goes on; or until something ends the run: returns what status() then says. Sleeps as the
  /// speed demands; returns early with `running` when paused and no command is waiting. Chopping a
  /// run into several calls changes nothing.
  RunStatus run_until(double end_time);
  /// One step. Once the run has ended, or while paused, it only applies commands (StepOnce, Resume
  /// and Restart among them).
  RunStatus step();

  /// From any thread; applied before the next step.
  void send(Command command);
  /// From any thread or a signal handler: ends the run at the next step boundary.
  void stop() noexcept;
  bool paused() const;

  SimulationSnapshotPtr save() const;
  /// Errors: a snapshot of another scene or backend. Controllers are configured anew when
  /// `restart_controllers`, else they go on with the memory they have.
  Result<> restore(const SimulationSnapshotPtr& snapshot, bool restart_controllers = false);

  /// Puts the library of a controller, as it lies on disk now, in the place of the one that runs;
  /// to be called between steps, by the thread that steps. `name`: the controller's, or that of an
  /// assembly with one controller. The new controller is configured and given what save() of the old
  /// one tells; targets of motors then stay as they are. If save() tells nothing it begins anew. One
  /// that was stopped by a fault runs again. Restarts use the new library too, as do controllers
  /// that come later. Errors, after which all is as it was: no such controller; the run has ended;
  /// the library cannot be loaded; its parameters do not take the scene's, or it publishes something
  /// else than before; configure() fails; the memory does not fit.
  Result<Reloaded> reload_controller(const std::string& name);

  /// The sensor objects' channels, by sensor index.
  const std::vector<Channel>& channels(int sensor) const;

  struct Impl;

 private:
  friend struct SnapshotAccess;  // snapshots on file
  explicit Simulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cogrsim
