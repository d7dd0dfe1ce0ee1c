// Rules of the scene: their firing, their scheduled actions, and the lifetimes of assemblies.
#include <algorithm>
#include <cmath>

#include "simulation/impl.h"

namespace cogrsim {

namespace {

/// A step boundary counts as reached up to a millionth of a step earlier, as for rates.
constexpr double kEarly = 1e-6;

// The last cycle of the rule in the chain of causes: "open -> enter -> open".
std::string circle(const SceneModel& model, const Causes& causes, int rule) {
  std::string out;
  const auto last = std::find(causes.rbegin(), causes.rend(), rule);
  for (auto it = last.base() - 1; it != causes.end(); ++it) {
    out += "'" + model.rules[static_cast<std::size_t>(*it)].name + "' -> ";
  }
  return out + "'" + model.rules[static_cast<std::size_t>(rule)].name + "'";
}

}  // namespace

void Simulation::Impl::publish_event(Event event) {
  cached.reset();  // the cached frame does not contain the event
  for (SupervisorSlot& slot : supervisors) {
    if (slot.events.size() < kMaxEventsPerStep) slot.events.push_back(event);
  }
  if (events.size() < kMaxEventsPerStep) {
    events.push_back(std::move(event));
    event_causes.push_back(causes);
    return;
  }
  if (std::exchange(event_system.memory.event_limit_reported, true)) return;
  log.report(Severity::error, "run",
         "more than " + std::to_string(kMaxEventsPerStep) +
             " events in one step; excess events are discarded, now and later");
}

void Simulation::Impl::detect_events() {
  if (model->rules.empty() && model->regions.empty() && model->doors.empty()) {
    event_system.memory.started = true;
    return;
  }
  std::vector<Event> seen;
  event_system.detect(model, present_state(), time(), seen);
  for (Event& event : seen) publish_event(std::move(event));
  if (!model->rules.empty()) fire_rules();
}

void Simulation::Impl::fire_rules() {
  const auto channels = [this](int sensor) -> const std::vector<Channel>* {
    return &sensors.channels(static_cast<std::size_t>(sensor));
  };
  const auto& conditions = event_system.conditions(model, channels);
  const double now = time() + kEarly * clock.dt();
  for (std::size_t i = 0; i < model->rules.size(); ++i) {
    const RuleModel& rule = model->rules[i];
    RuleMemory& memory = event_system.memory.rules[i];
    if (memory.off) continue;
    bool holds = true, rises = false;
    if (!rule.when.empty()) {
      holds = conditions[i] && conditions[i]->holds(*frame_with(conditions[i]->needs()));
      rises = holds && !memory.held;
      memory.held = holds;
    }
    bool on_its_own = true;
    if (!rule.kind.empty()) {
      on_its_own = false;
      for (std::size_t e = 0; e < events.size() && holds && !memory.off; ++e) {
        if (matches(rule, events[e])) fire(i, event_causes[e]);
      }
    }
    if (rule.every || rule.time) {
      on_its_own = false;
      const double period = rule.every.value_or(0.0);
      const double first = rule.time.value_or(period);
      bool due = false;
      // Several periods within one step count as one. A period too short to be counted: every step.
      const bool countless = rule.every && !(period > 1e-15 * (now - first));
      if (countless) due = first <= now;
      // All but the last period are skipped at once; the last one is determined exactly.
      if (rule.every && !countless) {
        const double over = std::floor((now - first) / period) - 1.0;
        if (over > static_cast<double>(memory.rounds))
          memory.rounds = static_cast<std::uint64_t>(over);
      }
      while (!countless && (rule.every || memory.rounds == 0) &&
             first + static_cast<double>(memory.rounds) * period <= now) {
        ++memory.rounds;
        due = true;
      }
      if (due && holds) fire(i, {});
    }
    if (on_its_own && rises) fire(i, {});
  }
}

void Simulation::Impl::fire(std::size_t rule, const Causes& led_to) {
  const RuleModel& description = model->rules[rule];
  RuleMemory& memory = event_system.memory.rules[rule];
  const int index = static_cast<int>(rule);
  const std::string who = "rule '" + description.name + "'";
  const std::string where = place_of(*model, description.origin);
  if (std::count(led_to.begin(), led_to.end(), index) >= kMaxRounds) {
    memory.off = true;
    log.report(Severity::error, who,
           (where.empty() ? "" : where + ": ") + who + " triggers itself repeatedly: " +
               circle(*model, led_to, index) + "; it is switched off after " +
               std::to_string(kMaxRounds) + " rounds, the run continues");
    return;
  }
  if (memory.fired >= description.limit) {
    // A limit of 1 is the intention of the author and needs no warning.
    if (description.limit == 1 || std::exchange(memory.limit_reported, true)) return;
    log.report(Severity::warning, who,
           (where.empty() ? "" : where + ": ") + who + " has fired " +
               std::to_string(description.limit) +
               " times, which is its limit; it does not fire any more");
    return;
  }
  if (event_system.memory.pending.size() >= kMaxPending) {
    if (std::exchange(event_system.memory.pending_limit_reported, true)) return;
    log.report(Severity::error, who,
           "more than " + std::to_string(kMaxPending) +
               " actions of rules are scheduled; excess actions are discarded");
    return;
  }
  ++memory.fired;
  PendingActions pending{time() + description.after, index, {}};
  // A delay starts a new chain of causes; otherwise the chain continues.
  if (description.after == 0.0) pending.causes = led_to;
  pending.causes.push_back(index);
  if (pending.causes.size() > kMaxCauses) pending.causes.erase(pending.causes.begin());
  event_system.memory.pending.push_back(std::move(pending));
}

void Simulation::Impl::apply_due() {
  EventState& memory = event_system.memory;
  const double now = time() + kEarly * clock.dt();
  const auto over = [now](const auto& entry) { return entry.due <= now; };
  if (std::any_of(memory.lifetimes.begin(), memory.lifetimes.end(), over)) {
    for (const Lifetime& lifetime : std::vector<Lifetime>(memory.lifetimes)) {
      const auto index = static_cast<std::size_t>(lifetime.assembly);
      if (!over(lifetime) || model->assemblies[index].removed) continue;
      if (auto done = remove_named(std::string(model->assemblies[index].name)); !done) {
        refused(done.error());
      }
      world_changed();
    }
    memory.lifetimes.erase(std::remove_if(memory.lifetimes.begin(), memory.lifetimes.end(), over),
                           memory.lifetimes.end());
  }
  if (!std::any_of(memory.pending.begin(), memory.pending.end(), over)) return;
  std::vector<PendingActions> due;
  std::copy_if(memory.pending.begin(), memory.pending.end(), std::back_inserter(due), over);
  memory.pending.erase(std::remove_if(memory.pending.begin(), memory.pending.end(), over),
                       memory.pending.end());
  std::stable_sort(due.begin(), due.end(),
                   [](const PendingActions& a, const PendingActions& b) { return a.due < b.due; });
  for (const PendingActions& pending : due) {
    causes = pending.causes;
    for (const Action& action : model->rules[static_cast<std::size_t>(pending.rule)].actions) {
      Command command = std::visit([](const auto& a) { return Command(a); }, action);
      apply(command);
    }
  }
  causes.clear();
}

}  // namespace cogrsim
