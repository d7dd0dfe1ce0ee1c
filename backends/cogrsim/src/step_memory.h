// What steps leave beside the state.
#pragma once

#include <vector>

#include "contacts.h"

namespace cogrsim::dynamics {

/// Sums of effort times time; one entry per speed and per motor of the model.
struct EffortSums {
  std::vector<double> joints;
  std::vector<double> motors;
};

/// What a step takes from the one before, beside the state. All of it is part of a snapshot.
struct StepMemory {
  std::vector<WarmContact> contacts;  ///< in the order of the colliders
  std::vector<double> efforts;        ///< see RowBuilder::slot_of; empty: none
  Values udot;       ///< what leads to the next middle of a step, impulses of contacts included
  Values mean_udot;  ///< over the last step, impulses included; empty: unknown
  bool had_rows = false;  ///< `udot` and the rest are valid
  void clear() { *this = {}; }
};

}  // namespace cogrsim::dynamics
