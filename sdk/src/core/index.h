// Conversion of indices: CogRSim uses int, where -1 means the world or none; standard containers
// use std::size_t.
#pragma once

#include <cstddef>

namespace cogrsim {

inline std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace cogrsim
