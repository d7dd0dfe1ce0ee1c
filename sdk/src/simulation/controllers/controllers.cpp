// Hosting of controllers and supervisors: loading, configuring, updating, and handling of faults.
#include <algorithm>

#include "simulation/impl.h"

namespace cogrsim {

SupervisorSlot::SupervisorSlot() = default;
SupervisorSlot::SupervisorSlot(SupervisorSlot&&) noexcept = default;
SupervisorSlot& SupervisorSlot::operator=(SupervisorSlot&&) noexcept = default;
SupervisorSlot::~SupervisorSlot() {
  if (!supervisor) return;
  const PluginCall call = context->calling("while it was destroyed");
  supervisor.reset();  // before the context, to which it may still refer
}

namespace {

struct LoadedController {
  PluginPtr plugin;
  Parameters parameters;
};

/// Loads the plugin of a controller and completes its parameters; errors are appended to `found`.
std::optional<LoadedController> load_controller(const Simulation::Impl& simulation, PluginKind kind,
                                                const ControllerModel& description,
                                                std::vector<Diagnostic>& found) {
  auto plugin = simulation.loader->load(kind, description.plugin);
  if (!plugin) {
    found.push_back(simulation.problem(plugin.error().message, description.origin,
                                       plugin.error().code, plugin.error().hint));
    return std::nullopt;
  }
  auto parameters = complete_parameters((*plugin)->descriptor().parameters, description.parameters);
  if (!parameters) {
    found.push_back(simulation.problem(std::string(to_string(kind)) + " '" + description.plugin +
                                           "': " + parameters.error().message,
                                       description.origin, "CG0904", parameters.error().hint));
    return std::nullopt;
  }
  return LoadedController{*plugin, std::move(*parameters)};
}

std::string assembly_name(const SceneModel& model, int assembly) {
  return assembly < 0 ? "the scene" : model.assemblies[static_cast<std::size_t>(assembly)].name;
}

// Reports the errors of configure(): a thrown exception and the collected errors.
void report_mistakes(const Simulation::Impl& simulation, const ControllerModel& description,
                     const std::string& who, const StartOutcome& outcome,
                     std::vector<Diagnostic>& found) {
  for (const std::string& mistake : outcome.mistakes) {
    found.push_back(simulation.problem(who + ": " + mistake, description.origin, "CG0907"));
  }
  if (outcome.failure) {
    found.push_back(simulation.problem(who + " " + *outcome.failure, description.origin, "CG0908"));
  }
}

}  // namespace

std::shared_ptr<AssemblyAccess> make_access(Simulation::Impl& simulation,
                                            const ControllerModel& description,
                                            const PluginPtr& plugin, Parameters parameters) {
  auto access = std::make_shared<AssemblyAccess>();
  access->simulation = &simulation;
  access->assembly = description.assembly;
  access->name = assembly_name(*simulation.model, description.assembly);
  access->controller = description.name;
  access->plugin = description.plugin;
  access->table = &plugin->descriptor().parameters;
  access->parameters = std::move(parameters);
  access->declared = &plugin->descriptor().outputs;
  access->outputs.assign(access->declared->size(), std::numeric_limits<double>::quiet_NaN());
  access->random.emplace(simulation.original->physics.seed, description.name);
  return access;
}

StartOutcome Simulation::Impl::start_controller(ControllerSlot& slot, std::size_t index) {
  StartOutcome outcome;
  if (model->controllers[index].isolation.value_or(isolation) == Isolation::process) {
    auto isolated = make_isolated_controller(slot.plugin, slot.access, index);
    if (!isolated) {
      outcome.failure = isolated.error().text();
      return outcome;
    }
    slot.controller = std::move(*isolated);
  } else {
    slot.controller = make_in_process_controller(slot.plugin, slot.access);
  }
  if (const auto failure = slot.controller->configure()) {
    outcome.failure = phrase(*failure, "while being configured");
  }
  outcome.mistakes = std::exchange(slot.access->mistakes, {});
  if (slot.access->fault) outcome.mistakes.push_back(*slot.access->fault);
  slot.access->fault.reset();
  return outcome;
}

std::vector<Diagnostic> Simulation::Impl::build_controller(std::size_t index) {
  std::vector<Diagnostic> found;
  const ControllerModel& description = model->controllers[index];
  ControllerSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (description.removed) {
    slot.clock.stopped = true;
  } else if (auto loaded = load_controller(*this, PluginKind::controller, description, found)) {
    slot.plugin = loaded->plugin;
    slot.access = make_access(*this, description, slot.plugin, std::move(loaded->parameters));
    const StartOutcome outcome = start_controller(slot, index);
    report_mistakes(*this, description,
                  "controller '" + description.plugin + "' of '" + slot.access->name + "'", outcome,
                    found);
  }
  controllers.push_back(std::move(slot));
  return found;
}

std::vector<Diagnostic> Simulation::Impl::build_supervisor(const ControllerModel& description) {
  std::vector<Diagnostic> found;
  SupervisorSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (auto loaded = load_controller(*this, PluginKind::supervisor, description, found)) {
    slot.plugin = loaded->plugin;
    slot.entry = static_cast<const SupervisorEntry*>(slot.plugin->descriptor().factory);
    slot.context = std::make_unique<LiveSupervisorContext>(
        *this, description, std::move(loaded->parameters), slot.plugin->descriptor().outputs,
        original->physics.seed);
    const PluginCall call = slot.context->calling("while being configured");
    Supervisor* made = nullptr;
    auto thrown = slot.entry->create(made);
    slot.supervisor = {made, slot.entry->destroy};
    if (made) {
      slot.needs = made->needs();
      slot.context->show(frame_with(slot.needs));
      thrown = slot.entry->configure(*made, *slot.context);
    }
    StartOutcome outcome;
    if (thrown) outcome.failure = "threw while being configured: " + *thrown;
    if (auto mistake = slot.context->take_fault()) outcome.mistakes.push_back(std::move(*mistake));
    report_mistakes(*this, description, "supervisor '" + description.plugin + "'", outcome, found);
  }
  supervisors.push_back(std::move(slot));
  return found;
}

void Simulation::Impl::run_controllers() {
  const double now = time(), dt = clock.dt();
  const auto tick_of = [&](ControllerClock& timing) {
    Tick tick;
    tick.time = now;
    tick.count = timing.count;
    tick.period = timing.count == 0 ? timing.timer.period(dt) : now - timing.last_time;
    timing.timer.advance(now, dt);
    timing.last_time = now;
    ++timing.count;
    return tick;
  };
  for (std::size_t i = 0; i < controllers.size() && status == RunStatus::running; ++i) {
    ControllerSlot& slot = controllers[i];
    if (slot.clock.stopped || !slot.clock.timer.due(now, dt)) continue;
    const auto failure = slot.controller->update(tick_of(slot.clock));
    const ControllerModel& description = model->controllers[i];
    if (failure) {
      fault(description, slot.clock, phrase(*failure, "in update"));
    } else if (slot.access->fault) {
      fault(description, slot.clock, *slot.access->fault);
    }
    slot.access->fault.reset();
    if (slot.clock.stopped) stop_motors(*slot.access);
  }
  for (std::size_t i = 0; i < supervisors.size() && status == RunStatus::running; ++i) {
    SupervisorSlot& slot = supervisors[i];
    if (slot.clock.stopped || !slot.clock.timer.due(now, dt)) continue;
    // A frame that another consumer requested in this step may be older than the sensor readings,
    // the controller outputs and the last events. The input of a supervisor must not depend on
    // that.
    std::shared_ptr<Frame> fresh = pool->take();
    *fresh = *frame_with(slot.needs);
    sensors.copy_readings(fresh->readings);
    copy_controller_outputs(*fresh);
    fresh->events = std::exchange(slot.events, {});
    slot.context->show(std::move(fresh));
    const Tick tick = tick_of(slot.clock);
    const PluginCall call = slot.context->calling("in update");
    if (auto thrown = slot.entry->update(*slot.supervisor, tick, *slot.context)) {
      fault(model->supervisors[i], slot.clock, "threw in update: " + *thrown);
    } else if (auto wrong = slot.context->take_fault()) {
      fault(model->supervisors[i], slot.clock, *wrong);
    }
  }
}

void Simulation::Impl::fault(const ControllerModel& description, ControllerClock& timing,
                             const std::string& message) {
  const std::string who = description.assembly < 0
                              ? "supervisor '" + description.plugin + "'"
                              : "controller '" + description.plugin + "' of '" +
                                    assembly_name(*model, description.assembly) + "'";
  timing.stopped = true;
  const bool ends = description.on_fault == FaultPolicy::end_run;
  log.report(Severity::error, who,
         message + (ends ? "; the run ends (on-fault=\"end-run\")"
                         : "; it is stopped, the run continues (on-fault=\"stop-controller\")"));
  publish_event({time(), "fault", description.name, message, ""});
  if (ends) status = RunStatus::fault;
}

// Stops a robot whose controller has stopped: targets become zero, and position motors hold.
void Simulation::Impl::stop_motors(const AssemblyAccess& access) {
  for (const int motor : access.motors) {
    const auto index = static_cast<std::size_t>(motor);
    const MotorMode mode = model->motors[index].mode;
    if (mode == MotorMode::position || mode == MotorMode::servo) continue;
    motors[index].target = 0.0;
  }
}

void LiveSupervisorContext::send(Command command) {
  if (simulation_.commands.send_own(std::move(command))) return;
  if (std::exchange(simulation_.event_system.memory.send_limit_reported, true)) return;
  const std::string why = "supervisor '" + name_ + "' sent more than " +
                          std::to_string(kMaxSentPerStep) +
                          " commands in one step; excess commands are discarded, now and later";
  simulation_.log.report(Severity::error, name_, why);
  simulation_.publish_event({simulation_.time(), "refused", name_, why, ""});
}

const ParameterValue* LiveSupervisorContext::parameter(const std::string& name) const {
  const auto found = parameters_.find(name);
  return found == parameters_.end() ? nullptr : &found->second;
}

void LiveSupervisorContext::publish(const std::string& output, double value) {
  if (auto wrong = publish_output(declared_, output, value, outputs_)) fault_ = std::move(wrong);
}

std::optional<std::string> publish_output(const std::vector<PluginOutput>& declared,
                                          const std::string& name, double value,
                                          std::vector<double>& outputs) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < declared.size(); ++i) {
    if (declared[i].name == name) {
      outputs[i] = value;
      return std::nullopt;
    }
    names.push_back(declared[i].name);
  }
  const std::string near = nearest_name(name, names);
  return "there is no declared output '" + name + "'" +
         (near.empty() ? "" : "; did you mean '" + near + "'?");
}

void LiveSupervisorContext::report(const std::string& message) {
  simulation_.log.report(Severity::note, name_, message);
}

}  // namespace cogrsim
