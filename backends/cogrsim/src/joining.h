// Velocities after something was joined or stopped all of a sudden.
#pragma once

#include <vector>

#include "mechanism.h"

namespace cogrsim::dynamics {

/// Changes the speeds of the mechanism's state such that `joints` (of any
/// model with the same bodies; the mechanism need not have them) do not forbid them and `stopped`
/// bodies rest: by the impulses of a perfectly plastic joining,
///   u += M^-1 J^T l,  (J M^-1 J^T) l = -J u,
/// which act through all joints there are and keep the momentum of what floats. Where the
/// conditions say a thing twice, the smallest impulses are taken.
void join_suddenly(Mechanism& mechanism, const SceneModel& model, const std::vector<int>& joints,
                   const std::vector<int>& stopped);

}  // namespace cogrsim::dynamics
