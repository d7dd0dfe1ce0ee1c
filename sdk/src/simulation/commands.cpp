// Commands, applied at a step boundary in the order of their arrival.
#include <cmath>

#include "cogrsim/sensing/sensor_models.h"
#include "core/index.h"
#include "model/diagnose.h"
#include "simulation/impl.h"

namespace cogrsim {

namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace

void Simulation::send(Command command) { impl_->commands.send(std::move(command)); }

void Simulation::Impl::apply_commands() {
  // Commands that arrive meanwhile wait for the next boundary.
  for (std::size_t waiting = commands.size(); waiting > 0 && !pace.single_step; --waiting) {
    std::optional<Command> command = commands.take();
    if (!command) return;  // a restart has removed some
    apply(*command);
  }
}

void Simulation::Impl::apply_due() {
  for (const Lifetime& lifetime : events.take_expired()) {
    const AssemblyInfo& assembly = model().assemblies[at(lifetime.assembly)];
    if (assembly.removed) continue;
    if (auto done = actions.apply(Remove{assembly.name}); !done) refused(done.error());
    world_changed();
  }
  for (PendingActions& pending : events.take_due()) {
    events.set_causes(std::move(pending.causes));
    const SceneModelPtr scene = host.model();  // an action may replace it
    for (const Action& action : scene->rules[at(pending.rule)].actions) {
      Command command = std::visit([](const auto& a) { return Command(a); }, action);
      apply(command);
    }
  }
  events.set_causes({});
}

void Simulation::Impl::refused(const Error& error) {
  const bool too_many = error.code == kTooMany;
  if (too_many && std::exchange(events.memory.spawn_limit_reported, true)) return;
  log.report(Severity::error, "command", error.text());
  events.publish("refused", "", error.message);
}

void Simulation::Impl::apply(Command& command) {
  const Result<> done =
      std::visit(Overloaded{[&](Pause&) -> Result<> {
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
                              if (!(c.dt >= kShortestStep) || !std::isfinite(c.dt))
                                return fail("the step must be at least 1e-9 s");
                              if (c.dt < clock.dt()) {
                                const auto found = unusable_delays(*host.model(), c.dt);
                                if (!found.empty()) return tl::unexpected(found.front().error);
                                auto late =
                                    devices.sensors().unusable_latency(*host.model(), c.dt);
                                if (late) return tl::unexpected(std::move(*late));
                              }
                              clock.set_dt(c.dt);
                              return {};
                            },
                            [&](Restart& c) { return restart(c.seed); },
                            [&](ApplyForce& c) { return forces.apply(c, host, clock); },
                            [&](SetInput& c) { return controllers.set_input(c); },
                            [&](EndRun& c) -> Result<> {
                              // At the end of its step, so that the last events are published.
                              ending = true;
                              events.publish("ended", "", c.reason);
                              if (!c.reason.empty())
                                log.report(Severity::note, "run", "ended: " + c.reason);
                              return {};
                            },
                            [&](LogMessage& c) -> Result<> {
                              log.report(Severity::note, "scene", c.message);
                              return {};
                            },
                            [&](Raise& c) -> Result<> {
                              events.publish("raised", c.event, c.message);
                              return {};
                            },
                            [&](auto& c) { return actions.apply(c); }},
                 command);
  world_changed();
  if (!done) refused(done.error());
}

Result<> Simulation::Impl::restart(std::optional<std::uint64_t> seed) {
  if (auto done = host.restart(seed); !done) return done;
  clock.restart();
  start_shown = false;
  status = RunStatus::running;
  ending = false;
  events.reset(model(), host.seed());
  forces.set_applied({});
  world_changed();
  commands.restore({});  // those that the previous run has sent do not apply to this one
  std::vector<Diagnostic> found = build_all();
  // They may be drawn for each run, and the step be another one than the scene's.
  for (const UnusableDelay& it : unusable_delays(model(), clock.dt()))
    found.push_back(to_diagnostic(it.error));
  events.publish("restarted", "");
  if (!found.empty()) {
    status = RunStatus::fault;
    return fail("restart: " + joined(found), found.front());
  }
  return {};
}

}  // namespace cogrsim
