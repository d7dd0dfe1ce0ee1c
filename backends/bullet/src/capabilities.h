// What Bullet can do, feature by feature.
#pragma once

#include "cogrsim/physics/capabilities.h"

namespace cogrsim::bullet {

Capabilities make_capabilities();

}  // namespace cogrsim::bullet
