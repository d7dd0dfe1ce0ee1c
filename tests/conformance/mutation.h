// Deliberate faults: a suite that stays green with one of these has a hole.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/physics/backend.h"

namespace conformance {

struct Mutation {
  std::string name;
  double amount = 1.0;
};

/// Every fault, with the meaning of `amount`: for --help.
std::vector<std::string> mutation_help();

/// "gravity=1.01". Errors: unknown name (lists what exists), no number.
cogrsim::Result<Mutation> parse_mutation(const std::string& text);

/// The same backend with the fault built in.
std::shared_ptr<const cogrsim::Backend> mutated(std::shared_ptr<const cogrsim::Backend> backend,
                                                const Mutation& mutation);

}  // namespace conformance
