// Frames of the world's parts.
#pragma once

#include "cogrsim/geometry/placement.h"

namespace cogrsim::dynamics {

using geometry::Placement;

}  // namespace cogrsim::dynamics
