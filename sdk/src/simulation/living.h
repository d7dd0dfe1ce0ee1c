// What happens in a scene by itself: who comes into regions, doors that arrive, the scene's rules.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/signals/condition.h"
#include "simulation/living_memory.h"

namespace cogrsim {

// Bounds of what one run may set off; beyond them things are refused with one message.

/// A rule that is itself this often among the causes of what sets it off is switched off.
inline constexpr int kMaxRounds = 16;
/// Longest memory of causes; a longer circle of rules is ended by their limits.
inline constexpr std::size_t kMaxCauses = 256;
inline constexpr std::size_t kMaxPending = 10000;       ///< rules' actions that wait
inline constexpr std::size_t kMaxEventsPerStep = 1000;  ///< in a frame
inline constexpr std::size_t kMaxSentPerStep = 10000;   ///< commands of all supervisors together
inline constexpr int kMaxAddedPerStep = 100;            ///< assemblies that come in one step
inline constexpr int kMaxAddedBodies = 2000;            ///< that came during a run and are there

/// Code of what those bounds refuse: told once in a run.
inline constexpr const char* kTooMany = "too-many";

/// How near a door must be to its end to have arrived, as a share of its way.
inline constexpr double kDoorArrived = 0.02;

/// Whether a rule speaks of this event: its kind, and for each name either none in the rule, the same,
/// or that of an assembly around ("bot" for "bot.hand").
bool speaks_of(const RuleModel& rule, const Event& event);

/// Where a region's visitor is; nullopt: it is not there (any more).
std::optional<Vec3> place_of(const SceneModel& model, const WorldState& state, const Visitor& who);

/// Looks at the world after each step. Costs nothing in a scene without regions, doors and rules.
class Living {
 public:
  LivingMemory memory;

  /// A new run of this scene.
  void reset(const SceneModel& model, std::uint64_t seed);

  /// Adds to `events` what regions and doors see in a state. The first time of a run there is
  /// nothing to tell: who is in a region then did not come in.
  void look(const SceneModelPtr& model, const WorldState& state, double time,
            std::vector<Event>& events);

  /// Conditions of the rules that can be read in this model.
  const std::vector<std::optional<Condition>>& conditions(const SceneModelPtr& model,
                                                          const ChannelLookup& channels);

  /// Takes over what came with a new model: regions, doors.
  void follow(const SceneModelPtr& model);

 private:
  void look_at_regions(const SceneModel& model, const WorldState& state, double time,
                       std::vector<Event>& events);
  void look_at_doors(const SceneModel& model, const WorldState& state, double time,
                     std::vector<Event>& events);

  SceneModelPtr model_;                         // that `visitors_` belongs to
  std::vector<std::vector<Visitor>> visitors_;  // by region: whom it looks for
  SceneModelPtr conditions_model_;
  std::vector<std::optional<Condition>> conditions_;  // by rule
};

}  // namespace cogrsim
