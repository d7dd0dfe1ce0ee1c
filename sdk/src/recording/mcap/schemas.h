// The compiled schemas (FileDescriptorSets) that a recording contains.
#pragma once

#include <string_view>

namespace cogrsim {

std::string_view cogrsim_schemas();   ///< proto/cogrsim.proto
std::string_view foxglove_schemas();  ///< proto/foxglove.proto and its imports

}  // namespace cogrsim
