// What the MuJoCo backend can do.
#pragma once

#include "cogrsim/physics/capabilities.h"

namespace cogrsim::mujoco {

Capabilities make_capabilities();

}  // namespace cogrsim::mujoco
