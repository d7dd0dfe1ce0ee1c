// Whether a point lies in a shape.
#pragma once

#include "cogrsim/model/scene_model.h"

namespace cogrsim::geometry {

/// True when `p` (shape's frame [m]) lies deeper than `margin` [m] inside; on the surface is
/// outside. A mesh is asked for its winding number (a margin is not minded), a heightmap holds what
/// is below its ground, a plane all below it.
bool inside_shape(const SceneModel& model, const Shape& shape, const Vec3& p, double margin = 1e-9);

}  // namespace cogrsim::geometry
