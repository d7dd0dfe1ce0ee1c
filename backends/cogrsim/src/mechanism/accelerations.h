// Smooth accelerations: gravity, Coriolis and gyroscopic terms, explicit springs, dampers, motors.
#pragma once

#include <vector>

#include "drives.h"
#include "mechanism/mechanism.h"

namespace cogrsim::dynamics {

class Accelerations {
 public:
  explicit Accelerations(Mechanism& mechanism);

  /// Rows will need the factor of M at the states to come.
  bool with_rows = false;

  /// udot = M^-1 (f - c) at the mechanism's state: by the factor of M where that is small or rows need
  /// it, else by recursion. Loops are then closed, see loops.h.
  ///
  /// `middle`: the state is the middle of a step, reached by an acceleration, and accelerations are
  /// those that keep the mean speed over the whole step on the loops.
  struct Middle {
    double h = 0.0;                ///< the step [s]
    const Values* udot = nullptr;  ///< u at the middle is u0 + h / 2 udot
  };
  void compute(const std::vector<AxisLaw>& laws, Values& udot, const Middle* middle = nullptr);
  /// The same without the forces in the loops.
  void compute_open(const std::vector<AxisLaw>& laws, Values& udot);

 private:
  void close(const Middle* middle, Values& udot);

  Mechanism& mechanism_;
  std::vector<double> local_, wanted_, start_;
};

}  // namespace cogrsim::dynamics
