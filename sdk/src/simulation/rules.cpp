// What a scene does by itself: rules that fire, their actions when they are due, lifetimes.
#include <algorithm>
#include <cmath>

#include "simulation/impl.h"

namespace cogrsim {

namespace {

/// Boundaries a millionth of a step early count as reached, as for rates.
constexpr double kEarly = 1e-6;

// From the last time the rule is among the causes: "open -> enter -> open".
std::string circle(const SceneModel& model, const Causes& causes, int rule) {
  std::string out;
  const auto last = std::find(causes.rbegin(), causes.rend(), rule);
  for (auto it = last.base() - 1; it != causes.end(); ++it) {
    out += "'" + model.rules[static_cast<std::size_t>(*it)].name + "' -> ";
  }
  return out + "'" + model.rules[static_cast<std::size_t>(rule)].name + "'";
}

}  // namespace

void Simulation::Impl::happen(Event event) {
  cached.reset();  // the frame there was does not have it
  for (SupervisorSlot& slot : supervisors) {
    if (slot.events.size() < kMaxEventsPerStep) slot.events.push_back(event);
  }
  if (events.size() < kMaxEventsPerStep) {
    events.push_back(std::move(event));
    event_causes.push_back(causes);
    return;
  }
  if (std::exchange(living.memory.event_limit_told, true)) return;
  report(Severity::error, "run",
         "more than " + std::to_string(kMaxEventsPerStep) +
             " events in one step; what is more is left out, now and later");
}

void Simulation::Impl::look_around() {
  if (model->rules.empty() && model->regions.empty() && model->doors.empty()) {
    living.memory.started = true;
    return;
  }
  std::vector<Event> seen;
  living.look(model, present_state(), time(), seen);
  for (Event& event : seen) happen(std::move(event));
  if (!model->rules.empty()) fire_rules();
}

void Simulation::Impl::fire_rules() {
  const auto channels = [this](int sensor) -> const std::vector<Channel>* {
    return &sensors.channels(static_cast<std::size_t>(sensor));
  };
  const auto& conditions = living.conditions(model, channels);
  const double now = time() + kEarly * dt;
  for (std::size_t i = 0; i < model->rules.size(); ++i) {
    const RuleModel& rule = model->rules[i];
    RuleMemory& memory = living.memory.rules[i];
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
        if (speaks_of(rule, events[e])) fire(i, event_causes[e]);
      }
    }
    if (rule.every || rule.time) {
      on_its_own = false;
      const double period = rule.every.value_or(0.0);
      const double first = rule.time.value_or(period);
      bool due = false;
      // Rounds that a long step jumped over are one. More of them than can be counted: every step.
      const bool countless = rule.every && !(period > 1e-15 * (now - first));
      if (countless) due = first <= now;
      // Up to the last but one at a stroke; which is the last, rounding may not decide otherwise.
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
  RuleMemory& memory = living.memory.rules[rule];
  const int index = static_cast<int>(rule);
  const std::string who = "rule '" + description.name + "'";
  const std::string where = place_of(*model, description.origin);
  if (std::count(led_to.begin(), led_to.end(), index) >= kMaxRounds) {
    memory.off = true;
    report(Severity::error, who,
           (where.empty() ? "" : where + ": ") + who + " sets itself off again and again: " +
               circle(*model, led_to, index) + "; it is switched off after " +
               std::to_string(kMaxRounds) + " rounds, the run goes on");
    return;
  }
  if (memory.fired >= description.limit) {
    // "Once" is what its author wanted.
    if (description.limit == 1 || std::exchange(memory.limit_told, true)) return;
    report(Severity::advice, who,
           (where.empty() ? "" : where + ": ") + who + " has fired " +
               std::to_string(description.limit) +
               " times, as often as it may (limit); from now on it does not");
    return;
  }
  if (living.memory.pending.size() >= kMaxPending) {
    if (std::exchange(living.memory.pending_limit_told, true)) return;
    report(Severity::error, who,
           "more than " + std::to_string(kMaxPending) +
               " times actions of rules are waiting for their time; what is more is left out");
    return;
  }
  ++memory.fired;
  PendingActions pending{time() + description.after, index, {}};
  // What waits of its own will begins anew; else the chain of causes goes on.
  if (description.after == 0.0) pending.causes = led_to;
  pending.causes.push_back(index);
  if (pending.causes.size() > kMaxCauses) pending.causes.erase(pending.causes.begin());
  living.memory.pending.push_back(std::move(pending));
}

void Simulation::Impl::apply_due() {
  LivingMemory& memory = living.memory;
  const double now = time() + kEarly * dt;
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
