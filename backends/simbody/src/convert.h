// Between Eigen's and Simbody's small vectors.
#pragma once

#include "simbody_types.h"

namespace cogrsim::simbody {

using dynamics::from_simtk;
using dynamics::to_simtk;

inline Pose from_simtk(const SimTK::Transform& X) { return {from_simtk(X.p()), from_simtk(X.R())}; }

}  // namespace cogrsim::simbody
