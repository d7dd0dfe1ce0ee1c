// The options of `<dart …/>`, by DART's own names and with its own defaults but one.
#pragma once

#include "cogrsim/core/parameter.h"

namespace cogrsim::dart_engine {

const ParameterTable& world_option_table();

}  // namespace cogrsim::dart_engine
