// The table's part about what a person does in a run, and about tests; see protocol.h.
#pragma once

#include "protocol.h"

namespace cogrsim::studio {

void add_hand_requests(std::vector<ProtocolRequest>& requests);
void add_hand_types(std::vector<ProtocolType>& types);

}  // namespace cogrsim::studio
