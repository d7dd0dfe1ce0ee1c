// What a time step cannot hold, with any engine.
#pragma once

#include <utility>
#include <vector>

#include "simulation/clock.h"
#include "simulation/message_log.h"
#include "simulation/world_host.h"

namespace cogrsim {

/// Warns once in a run about each kind of motion that the step does not hold.
class StepLimits {
 public:
  /// Before a step: a hit in the first may take the spin that a body starts with.
  void check_start(WorldHost& host, const Clock& clock, MessageLog& log);
  /// After a step. Looks in some of them only, because reading the state has a cost.
  void check(WorldHost& host, const Clock& clock, MessageLog& log);

 private:
  // Rotations too fast for the step: integrators of any order lose accuracy if a body turns by a large
  // angle in a step, and wheels slip.
  bool check_spin(WorldHost& host, const Clock& clock, MessageLog& log);
  // Bodies pressed into each other, as where the sweeps do not carry a load over a large ratio of masses.
  bool check_overlap(WorldHost& host, MessageLog& log);

  bool spin_reported_ = false, overlap_reported_ = false;
  std::vector<Contact> contacts_;
  std::vector<std::pair<int, int>> deep_,
      now_deep_;  ///< pairs of bodies, in the last look and in this
};

}  // namespace cogrsim
