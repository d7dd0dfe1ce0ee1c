// The table's part about debugging, see protocol.h.
#pragma once

#include "protocol.h"

namespace cogrsim::studio {

void add_debug_requests(std::vector<ProtocolRequest>& requests);
void add_debug_types(std::vector<ProtocolType>& types);

}  // namespace cogrsim::studio
