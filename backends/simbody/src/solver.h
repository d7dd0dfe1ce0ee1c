// Impulses and displacements that make all rows hold: projected Gauss-Seidel.
#pragma once

#include <vector>

#include "rows.h"

namespace cogrsim::simbody {

struct SolverOptions {
  int iterations = 60;      ///< at most, in each stage
  double tolerance = 1e-7;  ///< stop when no impulse changes a velocity by more [m/s], [rad/s]
};

/// Velocity stage: finds the impulses of all rows, starting from those in the rows, and adds what
/// they do to `dv` (over all components), which the warm starts must not be in yet.
/// Projected Gauss-Seidel, one contact at a time (normal, then friction on the disc of Coulomb);
/// Anitescu and Potra, Nonlinear Dynamics 14, 1997; Catto, GDC 2005. Sweeps alternate in direction.
/// Components that no row ties together are solved each for itself and stop each in its own time.
/// The normals of a resting pair are solved at once. Small islands take conjugate steps between
/// sweeps (after Silcowitz, Niebe and Erleben, The Visual Computer 26, 2010; theirs after every
/// sweep, ours after each pair of sweeps there and back, a symmetric preconditioner).
/// Returns the most sweeps that an island took.
int solve_velocities(const SolverOptions& options, RowSet& set, double* dv);

/// Position stage ("split impulse"): displacements `p`, along W of the unilateral rows, that bring
/// gaps at the end of the step to their targets. `dv` from the velocity stage, `h` the step. Adds
/// no energy of motion.
void solve_positions(const SolverOptions& options, RowSet& set, const double* dv, double h,
                     double* p);

}  // namespace cogrsim::simbody
