// The options of Bullet's worlds, by Bullet's names and with its defaults.
#pragma once

#include "cogrsim/core/parameter.h"

namespace cogrsim::bullet {

const ParameterTable& world_option_table();

}  // namespace cogrsim::bullet
