// Why a policy stands here and falls there: one difference at a time is moved from the one to the other.
#pragma once

#include <string>
#include <vector>

#include "policy/transfer_table.h"

namespace cogrsim::cli {

struct ExplainOptions {
  SweepOptions sweep;    ///< with duration, seeds and output folder; `backends` is not used
  std::string from, to;  ///< engines: where it stands, where it falls; the same for two cards
  std::string against;   ///< a card that works; empty: the same card
  std::string command;   ///< empty: the card's
  std::string json;      ///< file, "-" or empty
  bool kept = true;      ///< the table of the runs stays
};

int explain(const ExplainOptions& options);

}  // namespace cogrsim::cli
