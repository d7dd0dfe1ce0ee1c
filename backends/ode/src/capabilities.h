// What the ODE backend can do.
#pragma once

#include "cogrsim/physics/capabilities.h"

namespace cogrsim::ode {

Capabilities make_capabilities();

}  // namespace cogrsim::ode
