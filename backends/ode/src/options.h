// The options of `<ode …/>`, by ODE's own names and with its own defaults.
#pragma once

#include "cogrsim/core/parameter.h"

namespace cogrsim::ode {

const ParameterTable& world_option_table();

}  // namespace cogrsim::ode
