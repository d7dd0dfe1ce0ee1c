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
  /// Three ways to the same figures: small trees by M^-1 (f - c) with the blocks that contact needs
  /// anyway, c from the closed forms of the joints where all have one, else from Simbody's inverse
  /// dynamics; long trees by Simbody's articulated-body recursion. Loops are then closed, see loops.h.
  ///
  /// `middle`: the state is the middle of a step, reached by an acceleration, and accelerations are
  /// those that keep the mean speed over the whole step on the loops.
  struct Middle {
    double h = 0.0;                       ///< the step [s]
    const SimTK::Vector* udot = nullptr;  ///< u at the middle is u0 + h / 2 udot
  };
  void compute(const std::vector<AxisLaw>& laws, SimTK::Vector& udot,
               const Middle* middle = nullptr);
  /// The same without the forces in the loops.
  void compute_open(const std::vector<AxisLaw>& laws, SimTK::Vector& udot);

 private:
  void compute_with_simbody(SimTK::Vector& udot);
  void solve_block(Component& component, double* udot);
  void close(const Middle* middle, SimTK::Vector& udot);
  void take_bias(Component& component) const;

  Mechanism& mechanism_;
  std::vector<Vec3> weights_;  ///< through each link's centre of mass (nlink)
  SimTK::Vector mobility_forces_, zero_, residual_;
  SimTK::Vector_<SimTK::SpatialVec> body_forces_, body_accelerations_, body_bias_;
  std::vector<double> local_, wanted_, start_;
};

}  // namespace cogrsim::dynamics
