// The run that the studio shows: simulations on a thread of their own, all frames so far, and the
// answers about them.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/plugin/loader.h"
#include "cogrsim/simulation/simulation.h"
#include "talk.h"

namespace cogrsim::studio {

/// What the page needs of a compiled scene beside the model: which element of the text made what.
/// Element ids as in the document's version; -1: none (made by an import, a prototype, a program).
struct Origins {
  struct Origin {
    int element = -1;
    bool own = false;  ///< that element is this thing and nothing else
  };
  std::uint64_t version = 0;  ///< of the document
  std::vector<Origin> bodies, assemblies, joints, motors, sensors, controllers, supervisors, lights,
      views, regions, plots, forces;
};

/// A scene that compiled.
struct Scene {
  SceneModelPtr model;
  Origins origins;
  /// Not empty: plugins were built, and come from these folders from now on (a new PluginLoader with
  /// them; loaded plugins stay loaded beside).
  std::vector<std::string> plugin_folders = {};
  /// Without what the text names and what is missing: to be looked at, and not to be run.
  bool only_shown = false;
};

struct RunOptions {
  std::string backend;  ///< empty: the scene's, else "bullet"
  double step = 0.0;    ///< [s]; 0: the scene's
  std::optional<std::uint64_t> seed;
  std::map<std::string, std::string> parameters;  ///< `--set`, for recordings
  std::string folder;                             ///< where recordings go: the scene's
  /// Frames kept for the timeline take this much memory; beyond, every second one of the older half
  /// is dropped [byte].
  std::size_t history_bytes = 512u << 20;
  Isolation isolation = Isolation::process;  ///< of controllers without the attribute
  std::vector<std::string> without;          ///< see SimulationOptions
};

/// What a controller reads that stands in the debugger.
struct HeldReading {
  std::string sensor;
  double time = 0.0;  ///< of the measurement [s]
  bool valid = false;
  std::vector<Channel> channels;
  std::vector<double> values;
};
struct HeldCall {
  double time = 0.0;  ///< of the run [s]
  std::vector<HeldReading> readings;
};

/// The part that answers everything in PROTOCOL.md under "The run" and "Numbers and pictures".
class Run : public Part {
 public:
  /// Of a scene still to come: see show().
  static std::unique_ptr<Run> of_scene(RunOptions options, std::shared_ptr<PluginLoader> loader,
                                       Outbox& outbox);
  /// Of a recording: no simulation. Errors: Recording::open's.
  static Result<std::unique_ptr<Run>> of_recording(const std::string& path,
                                                   std::shared_ptr<PluginLoader> loader,
                                                   Outbox& outbox);

  /// Continues with another scene: from the start at time 0; later with the state carried over by
  /// name, as Simulation's resume() does, where the element did not change its pose. One that a
  /// newer one follows before its turn comes is left out. From any thread; `done` is called from the
  /// run's: with what could not be carried over, or with why the engine refused the scene (the one
  /// before then stays), and once more when another engine has taken it.
  using ShowDone =
      std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)>;
  virtual void show(Scene scene, ShowDone done) = 0;

  /// Ends the simulations. Not empty: a plugin that did not return for 3 s, so that this object cannot
  /// be destroyed.
  virtual std::string finish() { return {}; }

  /// Called from the run's thread with the controllers whenever they may have got other processes,
  /// before they are updated; at once, if there is a run already. nullptr: not any more, when this
  /// returns. From any thread, but not from within `changed`.
  using ProcessListener = std::function<void(const std::vector<ControllerProcess>&)>;
  virtual void watch_processes(ProcessListener) {}  // NOLINT: what overrides it keeps the listener
  /// The listener is called once more as soon as the run's thread can. From any thread, and from
  /// within `changed`, too.
  virtual void ask_processes() {}
  /// While that controller is called: the time, and the readings of the sensors of its assembly. From
  /// any thread.
  virtual std::optional<HeldCall> held_call(const std::string& /*controller*/) { return {}; }

  /// The file behind /asset/NUMBER, see Inbox.
  virtual std::string asset(std::size_t number) const = 0;
};

}  // namespace cogrsim::studio
