// Changes of the scene of a run by commands and by the actions of its rules.
#pragma once

#include <string>

#include "cogrsim/control/command.h"
#include "simulation/controllers/controller_manager.h"
#include "simulation/device_manager.h"
#include "simulation/events/event_system.h"
#include "simulation/world_host.h"

namespace cogrsim {

/// Applies one command at a step boundary: to the model, the world, and the devices and controllers
/// of the elements. After an error nothing has changed.
class SceneActions {
 public:
  /// The arguments must outlive this object.
  SceneActions(PluginLoader& loader, const Clock& clock, WorldHost& host, DeviceManager& devices,
               ControllerManager& controllers, EventSystem& events)
      : loader_(loader),
        clock_(clock),
        host_(host),
        devices_(devices),
        controllers_(controllers),
        events_(events) {}

  Result<> apply(const AddAssembly& action) { return add(action, {}); }
  Result<> apply(const Remove& action);
  Result<> apply(const Spawn& action);
  Result<> apply(const Attach& action);
  Result<> apply(const Detach& action);
  Result<> apply(const SetJointLimits& action);
  Result<> apply(const SetStatic& action);
  Result<> apply(const MoveDoor& action);
  Result<> apply(const SetMotor& action);
  Result<> apply(const EnableSensor& action);
  Result<> apply(const SetKinematicTwist& action);
  Result<> apply(const SetState& action);

 private:
  /// `subject` is that of the event "added".
  Result<> add(const AddAssembly& action, const std::string& subject);
  Result<> check_capacity(const std::string& what, std::size_t bodies) const;
  /// Error: the engine lacks a feature that the model needs.
  Result<> check_supported(const SceneModel& next) const;
  const SceneModel& model() const { return *host_.model(); }

  PluginLoader& loader_;
  const Clock& clock_;
  WorldHost& host_;
  DeviceManager& devices_;
  ControllerManager& controllers_;
  EventSystem& events_;
};

}  // namespace cogrsim
