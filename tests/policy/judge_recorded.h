// Inputs for networks of others, of which the judge does not know what they are given.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cogrsim/policy/network.h"

namespace cogrsim::test {

using NetworkInputs = std::vector<std::vector<float>>;  // an entry per input

/// Normal random numbers.
Result<std::vector<NetworkInputs>> random_inputs(const PolicyNetwork& network, std::size_t count);

/// What the network of a card is given while it drives its robot on this engine, and its file. Errors: the card has some,
/// or the robot falls too early too often.
Result<std::vector<NetworkInputs>> recorded_inputs(const std::string& card,
                                                   const std::string& backend, std::size_t count,
                                                   std::shared_ptr<const PolicyNetwork>& network,
                                                   std::string& file);

}  // namespace cogrsim::test
