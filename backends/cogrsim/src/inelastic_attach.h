// Velocities after an inelastic attach or stop.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace cogrsim::dynamics {

/// Changes the speeds of the mechanism's state to satisfy `joints` (of any model with the same
/// bodies; the mechanism need not have them) and to stop the bodies `stopped`: by the impulses of a perfectly inelastic impact,
///   u += M^-1 J^T l,  (J M^-1 J^T) l = -J u,
/// which act through all joints and conserve the momentum of free mechanisms. Where conditions are
/// redundant, the smallest impulses are taken.
void attach_inelastically(Mechanism& mechanism, const SceneModel& model,
                          const std::vector<int>& joints, const std::vector<int>& stopped);

}  // namespace cogrsim::dynamics
