// The controllers of a run.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/simulation/simulation.h"
#include "control/process/proxy.h"
#include "simulation/controllers/hosted_plugin.h"
#include "simulation/controllers/local_devices.h"

namespace cogrsim {

struct ControllerSlot {
  PluginPtr plugin;
  std::shared_ptr<AssemblyAccess> access;
  std::unique_ptr<HostedController> controller;
  ControllerClock clock;

  bool runs() const { return controller && !clock.stopped; }
  RandomStream* random() const { return access ? &*access->random : nullptr; }
  std::vector<double>* outputs() const { return access ? &access->outputs : nullptr; }
  /// The state that the controller itself saves; none if it was never created.
  std::optional<HostFailure> save(std::optional<std::string>& memory) const {
    return controller ? controller->save(memory) : std::nullopt;
  }
  std::optional<HostFailure> restore(const std::string& memory) {
    return controller ? controller->restore(memory) : std::nullopt;
  }
};

/// Index of the controller with this name, or of the only controller of the assembly with this name.
Result<std::size_t> find_controller(const SceneModel& model, const std::string& name);

class ControllerManager {
 public:
  /// `isolation` is that of controllers that do not set it. The other arguments must outlive this
  /// object.
  ControllerManager(PluginLoader& loader, WorldHost& host, DeviceManager& devices,
                    const Clock& clock, MessageLog& log, EventSystem& events, Isolation isolation)
      : loader_(loader),
        host_(host),
        devices_(devices),
        clock_(clock),
        log_(log),
        events_(events),
        isolation_(isolation),
        port_(loader, host, devices, clock, log) {}

  /// Creates and configures the controllers of the model from index `first` on; those before are
  /// unchanged. Errors have the source location of the controller.
  std::vector<Diagnostic> build(std::size_t first);
  std::size_t size() const { return slots_.size(); }
  /// Destroys the controllers from index `first` on; their indices remain in use.
  void stop(std::size_t first);
  /// Destroys the controllers of removed elements; their indices remain in use.
  void drop_removed();

  /// Updates the controllers that are due, in the order of the model. False: a fault ends the run.
  bool update();

  /// See Simulation::reload_controller().
  Result<Reloaded> reload(const std::string& name, RunStatus status);

  /// See Simulation::controller_processes().
  std::vector<ControllerProcess> processes() const;

  /// See Simulation::controller_inputs().
  std::vector<ControllerInputs> inputs() const;
  Result<> set_input(const SetInput& command);

  /// The published outputs, as in Frame::controller_outputs.
  void copy_outputs(std::vector<std::vector<double>>& out) const;

  std::vector<HostedState> save() const;
  void restore(const std::vector<HostedState>& saved);
  std::vector<ControllerSlot>& slots() { return slots_; }
  const std::vector<ControllerSlot>& slots() const { return slots_; }

 private:
  static void stop(ControllerSlot& slot);
  std::vector<Diagnostic> build_one(std::size_t index);
  /// Creates and configures the controller of a slot that has its plugin and its access.
  StartOutcome start(ControllerSlot& slot, std::size_t index);
  std::optional<std::string> transfer_state(const ControllerSlot& old, ControllerSlot& fresh,
                                            std::size_t index, Reloaded& done);

  PluginLoader& loader_;
  WorldHost& host_;
  DeviceManager& devices_;
  const Clock& clock_;
  MessageLog& log_;
  EventSystem& events_;
  Isolation isolation_;
  LocalDevices port_;
  SceneForControllers scene_;
  std::vector<ControllerSlot> slots_;
};

}  // namespace cogrsim
