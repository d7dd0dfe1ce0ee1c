// What the parts of a scene that act by themselves remember: plain data, part of every snapshot.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace cogrsim {

/// Which rules led to something, the first one first, by SceneModel::rules; empty: none did. Only
/// the last kMaxCauses of them are kept.
using Causes = std::vector<int>;

/// Of a rule.
struct RuleMemory {
  int fired = 0;             ///< times so far
  std::uint64_t rounds = 0;  ///< of `every`, or of `time` (0 or 1), that are over
  bool held = false;         ///< its condition held in the last frame
  bool off = false;          ///< switched off: it kept setting itself off
  bool limit_told = false;
};

/// Of a door.
struct DoorMemory {
  bool open = false;    ///< where it was last sent
  bool arrived = true;  ///< it has been there since
};

/// Something that looks for itself where it is: of a region's `who`.
struct Visitor {
  enum class Kind { body, frame, assembly } kind = Kind::body;
  int index = -1;
  bool operator==(const Visitor& other) const { return kind == other.kind && index == other.index; }
};

/// Actions of a rule that wait for their time.
struct PendingActions {
  double due = 0.0;  ///< [s]
  int rule = -1;
  Causes causes;  ///< the rule itself last
};

struct Lifetime {
  double due = 0.0;   ///< [s]
  int assembly = -1;  ///< is removed then, if it is still there
};

struct LivingMemory {
  bool started = false;  ///< the start has been looked at
  std::vector<RuleMemory> rules;
  std::vector<DoorMemory> doors;
  std::vector<std::vector<Visitor>> inside;  ///< by region
  std::vector<PendingActions> pending;       ///< in the order they were set off
  std::vector<Lifetime> lifetimes;
  std::map<std::string, int> numbers;  ///< last one given to a template's copy
  std::uint64_t random = 0;            ///< state of the stream that spawns draw from
  int added_in_step = 0;               ///< assemblies
  bool spawn_limit_told = false;
  bool send_limit_told = false;
  bool event_limit_told = false;
  bool pending_limit_told = false;
};

}  // namespace cogrsim
