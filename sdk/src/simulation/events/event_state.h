// State of the event system (regions, doors, rules) as plain data; part of every snapshot.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cogrsim {

/// Chain of rules that caused an event or action, in order, as indices into SceneModel::rules;
/// empty: not caused by a rule. Only the last kMaxCauses are stored.
using Causes = std::vector<int>;

/// State of a rule.
struct RuleMemory {
  int fired = 0;             ///< number of firings
  std::uint64_t rounds = 0;  ///< number of elapsed periods of `every`, or of `time` (0 or 1)
  bool held = false;         ///< its condition was true in the last frame
  bool off = false;          ///< switched off, because it triggered itself repeatedly
  bool limit_reported = false;
};

/// State of a door.
struct DoorMemory {
  bool open = false;    ///< the last commanded position
  bool arrived = true;  ///< it has reached that position
};

/// An object that a region can detect, see RegionModel::who.
struct Visitor {
  enum class Kind { body, frame, assembly } kind = Kind::body;
  int index = -1;
  bool operator==(const Visitor& other) const { return kind == other.kind && index == other.index; }
};

/// Actions of a rule that are scheduled for a later time.
struct PendingActions {
  double due = 0.0;  ///< time at which they are applied [s]
  int rule = -1;
  Causes causes;  ///< ends with the rule itself
};

/// End of the lifetime of a spawned assembly.
struct Lifetime {
  double due = 0.0;   ///< time at which it is removed [s]
  int assembly = -1;  ///< index into SceneModel::assemblies
};

/// State of the whole event system.
struct EventState {
  bool started = false;  ///< the initial frame has been processed
  std::vector<RuleMemory> rules;
  std::vector<DoorMemory> doors;
  std::vector<std::vector<Visitor>> inside;  ///< objects inside each region
  std::vector<PendingActions> pending;       ///< in the order in which the rules fired
  std::vector<Lifetime> lifetimes;
  std::map<std::string, int> numbers;  ///< last number given to a copy of each template
  std::uint64_t random = 0;            ///< state of the random stream for spawning
  int added_in_step = 0;               ///< number of assemblies added in this step
  bool spawn_limit_reported = false;
  bool send_limit_reported = false;
  bool event_limit_reported = false;
  bool pending_limit_reported = false;
};

}  // namespace cogrsim
