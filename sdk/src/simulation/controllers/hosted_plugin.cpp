#include "simulation/controllers/hosted_plugin.h"

#include "model/diagnose.h"

namespace cogrsim {

Tick ControllerClock::tick(const Clock& clock) {
  const double now = clock.time();
  Tick tick;
  tick.time = now;
  tick.count = count;
  tick.period = count == 0 ? timer.period(clock.dt()) : now - last_time;
  timer.advance(now, clock.dt());
  last_time = now;
  ++count;
  return tick;
}

void name_outputs(SceneModel& model, PluginLoader& loader) {
  const auto name = [&](std::vector<ControllerModel>& controllers, PluginKind kind) {
    for (ControllerModel& controller : controllers) {
      const auto plugin = loader.load(kind, controller.plugin);
      if (!plugin) continue;  // reported when the controller is built
      controller.outputs.clear();
      for (const PluginOutput& output : (*plugin)->descriptor().outputs) {
        controller.outputs.push_back({output.name, output.unit});
      }
    }
  };
  name(model.controllers, PluginKind::controller);
  name(model.supervisors, PluginKind::supervisor);
}

std::optional<LoadedController> load_controller(const SceneModel& model, PluginLoader& loader,
                                                PluginKind kind, const ControllerModel& description,
                                                std::vector<Diagnostic>& found) {
  auto plugin = loader.load(kind, description.plugin);
  if (!plugin) {
    found.push_back(diagnose(model, description.origin, plugin.error().message, plugin.error().code,
                             plugin.error().hint));
    return std::nullopt;
  }
  auto parameters = complete_parameters((*plugin)->descriptor().parameters, description.parameters);
  if (!parameters) {
    found.push_back(diagnose(model, description.origin,
                             std::string(to_string(kind)) + " '" + description.plugin +
                                 "': " + parameters.error().message,
                             "CG0904", parameters.error().hint));
    return std::nullopt;
  }
  return LoadedController{*plugin, std::move(*parameters)};
}

void report_mistakes(const SceneModel& model, const ControllerModel& description,
                     const std::string& who, const StartOutcome& outcome,
                     std::vector<Diagnostic>& found) {
  for (const std::string& mistake : outcome.mistakes) {
    found.push_back(diagnose(model, description.origin, who + ": " + mistake, "CG0907"));
  }
  if (outcome.failure) {
    found.push_back(diagnose(model, description.origin, who + " " + *outcome.failure, "CG0908"));
  }
}

bool stop_after_fault(const SceneModel& model, const ControllerModel& description,
                      ControllerClock& timing, const std::string& message, MessageLog& log,
                      EventSystem& events) {
  const std::string who = description.assembly < 0
                              ? "supervisor '" + description.plugin + "'"
                              : "controller '" + description.plugin + "' of '" +
                                    assembly_name(model, description.assembly) + "'";
  timing.stopped = true;
  const bool ends = description.on_fault == FaultPolicy::end_run;
  log.report(
      Severity::error, who,
      message + (ends ? "; the run ends (on-fault=\"end-run\")"
                      : "; it is stopped, the run continues (on-fault=\"stop-controller\")"));
  events.publish("fault", description.name, message);
  return ends;
}

}  // namespace cogrsim
