// Publication of events, and the rules of the scene: their firing and their scheduled actions.
#include <algorithm>
#include <cmath>

#include "simulation/events/event_system.h"

namespace cogrsim {

namespace {

/// A step boundary counts as reached up to a millionth of a step earlier, as for rates.
constexpr double kEarly = 1e-6;

// The last cycle of the rule in the chain of causes: "open -> enter -> open".
std::string circle(const SceneModel& model, const Causes& causes, int rule) {
  std::string out;
  const auto last = std::find(causes.rbegin(), causes.rend(), rule);
  for (auto it = last.base() - 1; it != causes.end(); ++it) {
    out += "'" + model.rules[*it].name + "' -> ";
  }
  return out + "'" + model.rules[rule].name + "'";
}

// Moves the entries that are due at `now` [s] to `taken`, in their order.
template <class Entry>
void take(std::vector<Entry>& entries, double now, std::vector<Entry>& taken) {
  const auto over = [now](const Entry& entry) { return entry.due <= now; };
  if (std::none_of(entries.begin(), entries.end(), over)) return;
  std::copy_if(entries.begin(), entries.end(), std::back_inserter(taken), over);
  entries.erase(std::remove_if(entries.begin(), entries.end(), over), entries.end());
}

}  // namespace

void EventSystem::publish(Event event) {
  on_event_(event);
  if (events_.size() < kMaxEventsPerStep) {
    events_.push_back(std::move(event));
    led_to_.push_back(causes_);
    return;
  }
  if (std::exchange(memory.event_limit_reported, true)) return;
  log_.report(Severity::error, "run",
              "more than " + std::to_string(kMaxEventsPerStep) +
                  " events in one step; excess events are discarded, now and later");
}

void EventSystem::clear() {
  events_.clear();
  led_to_.clear();
}

void EventSystem::process(WorldHost& host, const SensorSuite& sensors, FrameSource& frames) {
  const SceneModelPtr& model = host.model();
  if (model->rules.empty() && model->regions.empty() && model->doors.empty()) {
    memory.started = true;
    return;
  }
  std::vector<Event> seen;
  detect(model, host.state(), clock_.time(), seen);
  for (Event& event : seen) publish(std::move(event));
  if (!model->rules.empty()) fire_rules(model, sensors, frames);
}

double EventSystem::boundary() const { return clock_.time() + kEarly * clock_.dt(); }

void EventSystem::fire_rules(const SceneModelPtr& model, const SensorSuite& sensors,
                             FrameSource& frames) {
  const auto channels = [&sensors](int sensor) -> const std::vector<Channel>* {
    return &sensors.channels(static_cast<std::size_t>(sensor));
  };
  const auto& resolved = conditions(model, channels);
  const double now = boundary();
  for (std::size_t i = 0; i < model->rules.size(); ++i) {
    const RuleModel& rule = model->rules[i];
    RuleMemory& state = memory.rules[i];
    if (state.off) continue;
    bool holds = true, rises = false;
    if (!rule.when.empty()) {
      holds = resolved[i] && resolved[i]->holds(*frames.frame_with(resolved[i]->needs()));
      rises = holds && !state.held;
      state.held = holds;
    }
    bool on_its_own = true;
    if (!rule.kind.empty()) {
      on_its_own = false;
      for (std::size_t e = 0; e < events_.size() && holds && !state.off; ++e) {
        if (matches(rule, events_[e])) fire(*model, i, led_to_[e]);
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
        if (over > static_cast<double>(state.rounds))
          state.rounds = static_cast<std::uint64_t>(over);
      }
      while (!countless && (rule.every || state.rounds == 0) &&
             first + static_cast<double>(state.rounds) * period <= now) {
        ++state.rounds;
        due = true;
      }
      if (due && holds) fire(*model, i, {});
    }
    if (on_its_own && rises) fire(*model, i, {});
  }
}

void EventSystem::fire(const SceneModel& model, std::size_t rule, const Causes& led_to) {
  const RuleModel& description = model.rules[rule];
  RuleMemory& state = memory.rules[rule];
  const int index = static_cast<int>(rule);
  const std::string who = "rule '" + description.name + "'";
  const std::string where = source_position(model, description.origin).position_text();
  if (std::count(led_to.begin(), led_to.end(), index) >= kMaxRounds) {
    state.off = true;
    log_.report(Severity::error, who,
                (where.empty() ? "" : where + ": ") + who + " triggers itself repeatedly: " +
                    circle(model, led_to, index) + "; it is switched off after " +
                    std::to_string(kMaxRounds) + " rounds, the run continues");
    return;
  }
  if (state.fired >= description.limit) {
    // A limit of 1 is the intention of the author and needs no warning.
    if (description.limit == 1 || std::exchange(state.limit_reported, true)) return;
    log_.report(Severity::warning, who,
                (where.empty() ? "" : where + ": ") + who + " has fired " +
                    std::to_string(description.limit) +
                    " times, which is its limit; it does not fire any more");
    return;
  }
  if (memory.pending.size() >= kMaxPending) {
    if (std::exchange(memory.pending_limit_reported, true)) return;
    log_.report(Severity::error, who,
                "more than " + std::to_string(kMaxPending) +
                    " actions of rules are scheduled; excess actions are discarded");
    return;
  }
  ++state.fired;
  PendingActions pending{clock_.time() + description.after, index, {}};
  // A delay starts a new chain of causes; otherwise the chain continues.
  if (description.after == 0.0) pending.causes = led_to;
  pending.causes.push_back(index);
  if (pending.causes.size() > kMaxCauses) pending.causes.erase(pending.causes.begin());
  memory.pending.push_back(std::move(pending));
}

std::vector<Lifetime> EventSystem::take_expired() {
  std::vector<Lifetime> expired;
  take(memory.lifetimes, boundary(), expired);
  return expired;
}

std::vector<PendingActions> EventSystem::take_due() {
  std::vector<PendingActions> due;
  take(memory.pending, boundary(), due);
  std::stable_sort(due.begin(), due.end(),
                   [](const PendingActions& a, const PendingActions& b) { return a.due < b.due; });
  return due;
}

}  // namespace cogrsim
