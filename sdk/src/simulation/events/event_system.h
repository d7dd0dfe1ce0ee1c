// The event system: the events of a run, detection of objects in regions and of door positions, and
// the rules of the scene.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/signals/condition.h"
#include "sensing/sensor_suite.h"
#include "simulation/events/event_state.h"
#include "simulation/frame_source.h"
#include "simulation/message_log.h"
#include "simulation/world_host.h"

namespace cogrsim {

// Limits of one run. A request beyond a limit is rejected with one message.

/// A rule that occurs this often in its own chain of causes is switched off.
inline constexpr int kMaxRounds = 16;
/// Largest stored length of a chain of causes; longer cycles of rules end by the limits of the
/// rules.
inline constexpr std::size_t kMaxCauses = 256;
inline constexpr std::size_t kMaxPending = 10000;       ///< scheduled actions of rules
inline constexpr std::size_t kMaxEventsPerStep = 1000;  ///< events in a frame
inline constexpr int kMaxAddedPerStep = 100;            ///< assemblies added in one step
inline constexpr int kMaxAddedBodies = 2000;            ///< existing bodies added during a run

/// Error code for an exceeded limit, which is reported only once in a run.
inline constexpr const char* kTooMany = "too-many";

/// A door has arrived if its distance to the end is at most this fraction of its travel.
inline constexpr double kDoorArrived = 0.02;

/// Whether an event matches a rule: the kinds are equal, and each name of the rule is empty, equal
/// to that of the event, or the name of an enclosing assembly ("bot" for "bot.hand").
bool matches(const RuleModel& rule, const Event& event);

/// Position of a visitor in the world [m]; nullopt: it does not exist (any more).
std::optional<Vec3> position_of(const SceneModel& model, const WorldState& state,
                                const Visitor& who);

/// The state that is part of snapshots is `memory`. Detection has no cost in a scene without
/// regions, doors and rules.
class EventSystem {
 public:
  EventState memory;

  /// `on_event` is called with every event, also with those that exceed the limit of a frame. The
  /// other arguments must outlive this object.
  EventSystem(const Clock& clock, MessageLog& log, std::function<void(const Event&)> on_event)
      : clock_(clock), log_(log), on_event_(std::move(on_event)) {}

  /// Starts a new run of this scene.
  void reset(const SceneModel& model, std::uint64_t seed);

  /// Adds an event to the next frame, caused by the current actions.
  void publish(Event event);
  void publish(const std::string& kind, const std::string& source, const std::string& message = {},
               const std::string& subject = {}) {
    publish({clock_.time(), kind, source, message, subject});
  }
  /// The events since the last frame.
  const std::vector<Event>& events() const { return events_; }
  void clear();

  /// Detects the events of regions and doors and fires rules, after a step and at the start.
  void process(WorldHost& host, const SensorSuite& sensors, FrameSource& frames);

  /// Removes and returns the assemblies whose lifetime has ended, or the actions that are due.
  std::vector<Lifetime> take_expired();
  std::vector<PendingActions> take_due();
  /// The causes of the events that follow.
  void set_causes(Causes causes) { causes_ = std::move(causes); }

  /// Adapts to a new model with additional regions and doors.
  void update_model(const SceneModelPtr& model);

 private:
  /// Appends the events of regions and doors in a state to `events`. The first call of a run
  /// generates no events, because objects that start inside a region do not enter it.
  void detect(const SceneModelPtr& model, const WorldState& state, double time,
              std::vector<Event>& events);
  /// The conditions of the rules that can be resolved in this model.
  const std::vector<std::optional<Condition>>& conditions(const SceneModelPtr& model,
                                                          const ChannelLookup& channels);
  void fire_rules(const SceneModelPtr& model, const SensorSuite& sensors, FrameSource& frames);
  void fire(const SceneModel& model, std::size_t rule, const Causes& led_to);
  double boundary() const;  ///< time up to which a step boundary counts as reached [s]
  void detect_in_regions(const SceneModel& model, const WorldState& state, double time,
                         std::vector<Event>& events);
  void detect_at_doors(const SceneModel& model, const WorldState& state, double time,
                       std::vector<Event>& events);

  const Clock& clock_;
  MessageLog& log_;
  std::function<void(const Event&)> on_event_;
  std::vector<Event> events_;                   // since the last frame
  std::vector<Causes> led_to_;                  // of each entry of `events_`
  Causes causes_;                               // of the current action
  SceneModelPtr model_;                         // the model that `visitors_` belongs to
  std::vector<std::vector<Visitor>> visitors_;  // the objects that each region detects
  SceneModelPtr conditions_model_;
  std::vector<std::optional<Condition>> conditions_;  // of each rule
};

}  // namespace cogrsim
