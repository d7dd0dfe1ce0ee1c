// Commands, applied at a step boundary in the order of their arrival.
#include <algorithm>
#include <cmath>

#include "simulation/impl.h"
#include "simulation/model_change.h"

namespace cogrsim {

namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

std::string joined(const std::vector<Diagnostic>& found) {
  std::string out;
  for (const Diagnostic& d : found) {
    if (!out.empty()) out += "; ";
    out += d.message;
  }
  return out;
}

}  // namespace

void Simulation::send(Command command) {
  impl_->commands.send(std::move(command));
}

void Simulation::Impl::apply_commands() {
  // Commands that arrive meanwhile wait for the next boundary.
  for (std::size_t waiting = commands.size(); waiting > 0 && !pace.single_step; --waiting) {
    std::optional<Command> command = commands.take();
    if (!command) return;  // a restart has removed some
    apply(*command);
  }
}

void Simulation::Impl::refused(const Error& error) {
  const bool too_many = error.code == kTooMany;
  if (too_many && std::exchange(event_system.memory.spawn_limit_reported, true)) return;
  log.report(Severity::error, "command", error.text());
  publish_event({time(), "refused", "", error.message, ""});
}

void Simulation::Impl::apply(Command& command) {
  const Result<> done = std::visit(
      Overloaded{[&](Pause&) -> Result<> {
                   pace.paused = true;
                   return {};
                 },
                 [&](Resume&) -> Result<> {
                   pace.paused = false;
                   return {};
                 },
                 [&](StepOnce&) -> Result<> {
                   pace.single_step = true;
                   return {};
                 },
                 [&](SetSpeed& c) -> Result<> {
                   if (!(c.factor > 0.0)) return fail("the speed must be above 0");
                   pace.speed = c.factor;
                   return {};
                 },
                 [&](SetStep& c) -> Result<> {
                   if (!(c.dt > 0.0) || !std::isfinite(c.dt))
                     return fail("the step must be above 0 s");
                   clock.set_dt(c.dt);
                   return {};
                 },
                 [&](Restart& c) { return restart(c.seed); },
                 [&](AddAssembly& c) { return add_assembly(c); },
                 [&](Remove& c) { return remove_named(c.name); },
                 [&](Spawn& c) { return spawn(c); },
                 [&](Attach& c) { return attach(c); },
                 [&](Detach& c) { return detach(c); },
                 [&](SetJointLimits& c) { return set_limits(c); },
                 [&](SetStatic& c) { return set_static(c); },
                 [&](MoveDoor& c) { return move_door(c); },
                 [&](SetMotor& c) { return set_motor(c.motor, c.target); },
                 [&](EnableSensor& c) -> Result<> {
                   const auto found = find_named(model->sensors, "sensor", c.sensor);
                   if (!found) return tl::unexpected(found.error());
                   sensors.enable(static_cast<std::size_t>(*found), c.on);
                   return {};
                 },
                 [&](SetKinematicTwist& c) -> Result<> {
                   const auto found = find_named(model->bodies, "body", c.body);
                   if (!found) return tl::unexpected(found.error());
                   auto* drive =
                       static_cast<KinematicDrive*>(world->extension(KinematicDrive::kId));
                   if (!drive) {
                     return fail("backend '" + std::string(backend->name()) +
                                 "' cannot move kinematic bodies while running");
                   }
                   return drive->set_kinematic_twist(*found, c.twist);
                 },
                 [&](SetState& c) -> Result<> { return world->set_state(c.state); },
                 [&](EndRun& c) -> Result<> {
                   // At the end of its step, so that the last events are published.
                   ending = true;
                   publish_event({time(), "ended", "", c.reason, ""});
                   if (!c.reason.empty()) log.report(Severity::note, "run", "ended: " + c.reason);
                   return {};
                 },
                 [&](LogMessage& c) -> Result<> {
                   log.report(Severity::note, "scene", c.message);
                   return {};
                 },
                 [&](Raise& c) -> Result<> {
                   publish_event({time(), "raised", c.event, c.message, ""});
                   return {};
                 }},
      command);
  world_changed();
  if (!done) refused(done.error());
}

Result<> Simulation::Impl::set_motor(const std::string& name, double target) {
  const auto found = find_named(model->motors, "motor", name);
  if (!found) return tl::unexpected(found.error());
  if (!std::isfinite(target))
    return fail("motor '" + name + "': the target is not a finite number");
  const auto index = static_cast<std::size_t>(*found);
  motors[index].target = clamp_target(*model, model->motors[index], target);
  return {};
}

Result<> Simulation::Impl::add_assembly(const AddAssembly& command, const std::string& subject) {
  if (!command.fragment) return fail("cannot add assembly '" + command.name + "': it is empty");
  const std::size_t bodies = command.fragment->bodies.size();
  if (auto checked = check_capacity("'" + command.name + "'", bodies); !checked) {
    return checked;
  }
  auto next = with_added(*model, *command.fragment, command.name, command.pose);
  if (!next) return tl::unexpected(next.error());
  for (const Diagnostic& d : check_capabilities(**next, backend->name(), backend->capabilities())) {
    if (d.severity == Severity::error) return fail(d.message, "", d.help, d.code);
  }
  if (!command.fragment->controllers.empty()) {
    auto named = std::make_shared<SceneModel>(**next);
    name_outputs(*named, *loader);
    next = SceneModelPtr(std::move(named));
  }
  // Devices are built first, on the new model, so that an error leaves the world unchanged.
  const SceneModelPtr before = model;
  const std::size_t sensors_before = sensors.size(), controllers_before = controllers.size();
  const std::size_t motors_before = motors.size();
  const auto undo = [&] {
    model = before;
    motors.resize(motors_before);
    sensors.cut(sensors_before);
    controllers.erase(controllers.begin() + static_cast<std::ptrdiff_t>(controllers_before),
                      controllers.end());
    world_changed();
  };
  if (auto added = world->add(*next); !added) return added;
  model = *next;
  world_changed();
  build_motors(motors_before);
  std::vector<Diagnostic> found = build_sensors(sensors_before);
  for (Diagnostic& d : build_controllers(controllers_before, false)) found.push_back(std::move(d));
  if (!found.empty()) {
    const std::string why = joined(found);
    // The bodies are already in the world, so they are removed again.
    auto without = with_removed(**next, command.name);
    undo();
    if (without && world->remove(*without)) {
      model = *without;
      build_motors(motors_before);
      build_sensors(sensors_before);
      build_controllers(controllers_before, false);
    }
    return fail("cannot add assembly '" + command.name + "': " + why);
  }
  ++event_system.memory.added_in_step;
  publish_event({time(), "added", command.name, "", subject});
  return {};
}

Result<> Simulation::Impl::remove_named(const std::string& name) {
  auto next = with_removed(*model, name);
  if (!next) return tl::unexpected(next.error());
  if (auto removed = world->remove(*next); !removed) return removed;
  const SceneModelPtr before = std::exchange(model, *next);
  for (std::size_t i = 0; i < controllers.size(); ++i) {
    if (!model->controllers[i].removed) continue;
    controllers[i].clock.stopped = true;
    controllers[i].controller.reset();
    if (controllers[i].access) controllers[i].access->parameters.clear();
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (model->sensors[i].removed) sensors.retire(i);
  }
  // Its joints to other assemblies are detached; its own joints are removed with it.
  for (std::size_t i = 0; i < model->joints.size(); ++i) {
    const Joint& joint = model->joints[i];
    if (!joint.removed || before->joints[i].removed) continue;
    if (joint.assembly >= 0 &&
        model->assemblies[static_cast<std::size_t>(joint.assembly)].removed) {
      continue;
    }
    publish_event(
        {time(), "detached", joint.name, "",
         joint.child == kWorld ? "" : model->bodies[static_cast<std::size_t>(joint.child)].name});
  }
  publish_event({time(), "removed", name, "", ""});
  return {};
}

Result<> Simulation::Impl::restart(std::optional<std::uint64_t> seed) {
  if (rebuild_on_restart) {
    auto fresh = backend->create_world(original);
    if (!fresh) return tl::unexpected(fresh.error());
    world = std::move(*fresh);
    rebuild_on_restart = false;
  } else if (auto done = world->reset(); !done) {
    return done;
  }
  if (seed && *seed != original->physics.seed) {
    auto reseeded = std::make_shared<SceneModel>(*original);
    reseeded->physics.seed = *seed;
    original = std::move(reseeded);
  }
  model = original;
  clock.restart();
  twists_before.clear();
  start_shown = false;
  status = RunStatus::running;
  ending = false;
  event_system.reset(*model, model->physics.seed);
  world_changed();
  commands.restore({});  // those that the previous run has sent do not apply to this one
  events.clear();
  event_causes.clear();
  const std::vector<Diagnostic> found = build_all();
  publish_event({0.0, "restarted", "", "", ""});
  if (!found.empty()) {
    status = RunStatus::fault;
    return fail("restart: " + joined(found));
  }
  return {};
}

}  // namespace cogrsim
