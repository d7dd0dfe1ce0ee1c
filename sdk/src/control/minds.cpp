// Hosting controllers and supervisors: loading, configuring, ticking, and what their faults do.
#include <algorithm>

#include "simulation/impl.h"

namespace cogrsim {

SupervisorSlot::SupervisorSlot() = default;
SupervisorSlot::SupervisorSlot(SupervisorSlot&&) noexcept = default;
SupervisorSlot& SupervisorSlot::operator=(SupervisorSlot&&) noexcept = default;
SupervisorSlot::~SupervisorSlot() {
  supervisor.reset();  // before the stage it may still refer to
}

namespace {

/// Loads the plugin of a mind and completes its parameters; `found` gets what is wrong.
struct LoadedMind {
  PluginPtr plugin;
  Parameters parameters;
};

std::optional<LoadedMind> load_mind(const Simulation::Impl& simulation, PluginKind kind,
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
  return LoadedMind{*plugin, std::move(*parameters)};
}

std::string assembly_name(const SceneModel& model, int assembly) {
  return assembly < 0 ? "the scene" : model.assemblies[static_cast<std::size_t>(assembly)].name;
}

// What configure() did wrong, thrown or noted.
void note_mistakes(const Simulation::Impl& simulation, const ControllerModel& description,
                   const std::string& who, const std::optional<std::string>& thrown,
                   const std::vector<std::string>& mistakes, std::vector<Diagnostic>& found) {
  for (const std::string& mistake : mistakes) {
    found.push_back(simulation.problem(who + ": " + mistake, description.origin, "CG0907"));
  }
  if (thrown) {
    found.push_back(simulation.problem(who + " threw while being configured: " + *thrown,
                                       description.origin, "CG0908"));
  }
}

}  // namespace

std::vector<Diagnostic> Simulation::Impl::build_controller(const ControllerModel& description) {
  std::vector<Diagnostic> found;
  ControllerSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (description.removed) {
    slot.clock.stopped = true;
  } else if (auto loaded = load_mind(*this, PluginKind::controller, description, found)) {
    slot.plugin = loaded->plugin;
    slot.entry = static_cast<const ControllerEntry*>(slot.plugin->descriptor().factory);
    slot.access = std::make_shared<AssemblyAccess>();
    slot.access->simulation = this;
    slot.access->assembly = description.assembly;
    slot.access->name = assembly_name(*model, description.assembly);
    slot.access->mind = description.name;
    slot.access->plugin = description.plugin;
    slot.access->table = &slot.plugin->descriptor().parameters;
    slot.access->parameters = std::move(loaded->parameters);
    slot.access->declared = &slot.plugin->descriptor().outputs;
    slot.access->outputs.assign(slot.access->declared->size(),
                                std::numeric_limits<double>::quiet_NaN());
    slot.access->random.emplace(original->physics.seed, description.name);
    const std::string who =
        "controller '" + description.plugin + "' of '" + slot.access->name + "'";
    Controller* made = nullptr;
    auto thrown = slot.entry->create(made);
    slot.controller = {made, slot.entry->destroy};
    if (made) {
      slot.robot = std::make_unique<Assembly>(slot.access);
      thrown = slot.entry->configure(*made, *slot.robot);
    }
    if (slot.access->fault) slot.access->mistakes.push_back(*slot.access->fault);
    slot.access->fault.reset();
    note_mistakes(*this, description, who, thrown, slot.access->mistakes, found);
  }
  controllers.push_back(std::move(slot));
  return found;
}

std::vector<Diagnostic> Simulation::Impl::build_supervisor(const ControllerModel& description) {
  std::vector<Diagnostic> found;
  SupervisorSlot slot;
  slot.clock.timer = RateTimer(description.rate);
  if (auto loaded = load_mind(*this, PluginKind::supervisor, description, found)) {
    slot.plugin = loaded->plugin;
    slot.entry = static_cast<const SupervisorEntry*>(slot.plugin->descriptor().factory);
    slot.stage = std::make_unique<SupervisorStage>(
        *this, description.name, std::move(loaded->parameters), slot.plugin->descriptor().outputs,
        original->physics.seed);
    Supervisor* made = nullptr;
    auto thrown = slot.entry->create(made);
    slot.supervisor = {made, slot.entry->destroy};
    if (made) {
      slot.needs = made->needs();
      slot.stage->show(frame_with(slot.needs));
      thrown = slot.entry->configure(*made, *slot.stage);
    }
    std::vector<std::string> mistakes;
    if (auto mistake = slot.stage->take_fault()) mistakes.push_back(std::move(*mistake));
    note_mistakes(*this, description, "supervisor '" + description.plugin + "'", thrown, mistakes,
                  found);
  }
  supervisors.push_back(std::move(slot));
  return found;
}

void Simulation::Impl::run_minds() {
  const double now = time();
  const auto tick_of = [&](MindClock& clock) {
    Tick tick;
    tick.time = now;
    tick.count = clock.count;
    tick.period = clock.count == 0 ? clock.timer.period(dt) : now - clock.last_time;
    clock.timer.advance(now, dt);
    clock.last_time = now;
    ++clock.count;
    return tick;
  };
  for (std::size_t i = 0; i < controllers.size() && status == RunStatus::running; ++i) {
    ControllerSlot& slot = controllers[i];
    if (slot.clock.stopped || !slot.clock.timer.due(now, dt)) continue;
    auto thrown = slot.entry->update(*slot.controller, tick_of(slot.clock));
    const ControllerModel& description = model->controllers[i];
    if (thrown) {
      fault(description, slot.clock, "threw in update: " + *thrown);
    } else if (slot.access->fault) {
      fault(description, slot.clock, *slot.access->fault);
    }
    slot.access->fault.reset();
    if (slot.clock.stopped) let_go(*slot.access);
  }
  for (std::size_t i = 0; i < supervisors.size() && status == RunStatus::running; ++i) {
    SupervisorSlot& slot = supervisors[i];
    if (slot.clock.stopped || !slot.clock.timer.due(now, dt)) continue;
    // A frame that somebody else asked for in this step may be older than the sensors' readings, the
    // controllers' outputs and the last events. What a supervisor sees must not depend on that.
    std::shared_ptr<Frame> fresh = pool->take();
    *fresh = *frame_with(slot.needs);
    sensors.copy_readings(fresh->readings);
    copy_controller_outputs(*fresh);
    fresh->events = std::exchange(slot.events, {});
    slot.stage->show(std::move(fresh));
    const Tick tick = tick_of(slot.clock);
    if (auto thrown = slot.entry->update(*slot.supervisor, tick, *slot.stage)) {
      fault(model->supervisors[i], slot.clock, "threw in update: " + *thrown);
    } else if (auto wrong = slot.stage->take_fault()) {
      fault(model->supervisors[i], slot.clock, *wrong);
    }
  }
}

void Simulation::Impl::fault(const ControllerModel& description, MindClock& clock,
                             const std::string& message) {
  const std::string who = description.assembly < 0
                              ? "supervisor '" + description.plugin + "'"
                              : "controller '" + description.plugin + "' of '" +
                                    assembly_name(*model, description.assembly) + "'";
  clock.stopped = true;
  const bool ends = description.on_fault == FaultPolicy::end_run;
  report(Severity::error, who,
         message + (ends ? "; the run ends (on-fault=\"end-run\")"
                         : "; it is stopped, the run goes on (on-fault=\"stop-controller\")"));
  happen({time(), "fault", description.name, message, ""});
  if (ends) status = RunStatus::fault;
}

// A robot without its controller comes to rest: drives go to zero, position drives hold.
void Simulation::Impl::let_go(const AssemblyAccess& access) {
  for (const int motor : access.motors) {
    const auto index = static_cast<std::size_t>(motor);
    const MotorMode mode = model->motors[index].mode;
    if (mode == MotorMode::position || mode == MotorMode::servo) continue;
    motors[index].target = 0.0;
  }
}

void SupervisorStage::send(Command command) {
  {
    std::lock_guard lock(simulation_.queue_mutex);
    if (simulation_.own_in_queue < kMaxSentPerStep) {
      simulation_.queue.push_back({std::move(command), true});
      ++simulation_.own_in_queue;
      return;
    }
  }
  if (std::exchange(simulation_.living.memory.send_limit_told, true)) return;
  const std::string why = "supervisor '" + name_ + "' sent more than " +
                          std::to_string(kMaxSentPerStep) +
                          " commands in one step; what is more is not carried out, now and later";
  simulation_.report(Severity::error, name_, why);
  simulation_.happen({simulation_.time(), "refused", name_, why, ""});
}

const ParameterValue* SupervisorStage::parameter(const std::string& name) const {
  const auto found = parameters_.find(name);
  return found == parameters_.end() ? nullptr : &found->second;
}

void SupervisorStage::publish(const std::string& output, double value) {
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

void SupervisorStage::report(const std::string& message) {
  simulation_.report(Severity::advice, name_, message);
}

}  // namespace cogrsim
