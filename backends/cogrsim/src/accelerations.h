// Smooth accelerations: gravity, Coriolis and gyroscopic terms, explicit springs, dampers, motors.
#pragma once

#include <vector>

#include "drives.h"
#include "mechanism.h"

namespace cogrsim::dynamics {

class Accelerations {
 public:
  explicit Accelerations(Mechanism& mechanism);

  /// udot at the mechanism's state, which is realized here where Simbody has a part in it.
  ///
  /// Four ways to the same figures: small trees by M^-1 (f - c) with the blocks that contact needs
  /// anyway, c from the closed forms of the joints where all have one, else from Simbody's inverse
  /// dynamics; long trees by Simbody's articulated-body recursion; systems with loops by Simbody's
  /// constrained forward dynamics.
  void compute(const std::vector<AxisLaw>& laws, SimTK::Vector& udot);

 private:
  void compute_with_simbody(SimTK::Vector& udot);
  void solve_block(Component& component, double* udot);

  Mechanism& mechanism_;
  std::vector<Vec3> weights_;  ///< through each link's centre of mass (nlink)
  SimTK::Vector mobility_forces_, zero_, residual_;
  SimTK::Vector_<SimTK::SpatialVec> body_forces_, body_accelerations_;
  std::vector<double> local_;
};

}  // namespace cogrsim::dynamics
