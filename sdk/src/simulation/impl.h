// Implementation of Simulation: the components of a run, their order in a step, and its frames.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "simulation/clock.h"
#include "simulation/command_queue.h"
#include "simulation/controllers/controller_manager.h"
#include "simulation/controllers/supervisor_manager.h"
#include "simulation/device_manager.h"
#include "simulation/events/event_system.h"
#include "simulation/force_system.h"
#include "simulation/frame_pool.h"
#include "simulation/frame_source.h"
#include "simulation/message_log.h"
#include "simulation/scene_actions.h"
#include "simulation/step_limits.h"
#include "simulation/world_host.h"

namespace cogrsim {

/// Shorter steps are lost in the rounding of the time [s].
inline constexpr double kShortestStep = 1e-9;

struct Simulation::Impl final : FrameSource {
  /// `scene` has the seed and the step of the run.
  Impl(std::shared_ptr<PluginLoader> plugins, std::shared_ptr<const Backend> backend,
       Provenance provenance, const SceneModelPtr& scene, const SimulationOptions& options);

  std::shared_ptr<PluginLoader> loader;  ///< destroyed last: frames may hold objects of plugins

  RunStatus status = RunStatus::running;
  Pace pace;
  std::atomic<bool> stop_requested{false};
  bool ending = false;  ///< the run ends with this step

  std::vector<std::shared_ptr<Observation::Slot>> observers;
  bool start_shown = false;  ///< the observers have received the initial frame

  std::shared_ptr<FramePool> pool = std::make_shared<FramePool>();
  FramePtr cached;  ///< frame of the current step
  FrameContents cached_contents;

  // In the order of use: a component is destroyed before those that it uses, so controllers and
  // sensors before the world, and all of them before the fields above.
  Clock clock;
  MessageLog log{clock};
  WorldHost host;
  DeviceManager devices;
  EventSystem events;
  ForceSystem forces;
  StepLimits limits;
  CommandQueue commands;
  SupervisorManager supervisors;
  ControllerManager controllers;
  SceneActions actions;

  const SceneModel& model() const { return *host.model(); }

  // create.cpp: builds devices, controllers and supervisors of the model; errors have the source
  // location of the element.
  std::vector<Diagnostic> build_controllers();
  std::vector<Diagnostic> build_all();

  // step.cpp
  RunStatus step();
  void show_start();
  void show_frame();  ///< passes the current frame to the observers
  bool wants_accelerations() const;
  FramePtr frame_with(const FrameContents& contents) override;
  std::shared_ptr<Frame> latest(const FrameContents& contents) override;
  void world_changed();

  // commands.cpp
  void apply_commands();
  void apply_due();  ///< applies scheduled actions and removes expired assemblies
  void apply(Command& command);
  void refused(const Error& error);
  Result<> restart(std::optional<std::uint64_t> seed);
};

}  // namespace cogrsim
