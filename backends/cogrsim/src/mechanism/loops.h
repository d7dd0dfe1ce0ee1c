// Joints that close loops: welds between the shadow of a split body, its copy, and the body's own link.
//
// With e(q) the closure errors of all welds (6 each: turn and shift of the shadow from its primary),
// G = de/dq N the rows they forbid and M the mass matrix,
//
//   accelerations  udot = a - M^-1 G' l,  A l = G a + b,  A = G M^-1 G'     (b: rate of G times u)
//   velocities     u   -= M^-1 G' l,      A l = G u                         (least change in M)
//   coordinates    q   -= N M^-1 G' l,    A l = e(q), repeated              (likewise)
//
// A is singular wherever rows are dependent: three of the six of each planar loop always, others in
// singular configurations (bifurcations), such as a folded parallelogram. Rows that
// add nothing are left out, found by a Cholesky factor of A, weld by weld in the order of their
// trees, largest remaining pivot of each weld's six first. A row of a weld touches the trees of its
// two links only, so the factor of a row of loops has an envelope as narrow as one of them.
//
// Near a singular position, at a distance of d from it, the last pivot that is used is about d^2.
// A right-hand side that is divided by this pivot must lie in the range of A. That is so for G u: the projections of velocities
// never enlarge anything. It is not so for b unless q and u are on the loop: an error y of q makes
// one of about y u^2 / d^2 in udot. Hence coordinates are brought back to rounding, and where a step
// comes too near (Stepper::pass_singular) b is the difference quotient (2 / h) G(qm) u0 in the middle
// of the step, which is in the range of A: then G(qm) (u0 + u1) = 0, and the impulses of the loop do
// no work whatever A is.
#pragma once

#include "mechanism/components.h"

namespace cogrsim::dynamics {

/// Rows, responses and factor of a component's welds; its mass matrix is factorized.
void update_loops(const Mechanism& mechanism, Component& component);

/// Projects x onto G x = wanted (6 nweld; 0 by default) with the least change in the norm of M:
/// x := x - M^-1 G' (G M^-1 G')^+ (G x - wanted).
void close_loops(const Component& component, double* x, const double* wanted = nullptr);

/// e := closure errors [rad], [m] (6 nweld) at the state; returns the largest.
double find_loop_gaps(const Mechanism& mechanism, const Component& component, double* e);

/// e := the welds' relative velocities (6 nweld) at the state, motion of kinematic bodies included.
void find_loop_speeds(const Mechanism& mechanism, const Component& component, double* e);

/// b := the welds' relative accelerations (6 nweld) at the state while all coordinates' are zero.
/// `bias`: those of the links, about the component's origin (see find_bias).
void find_loop_bias(const Mechanism& mechanism, const Component& component, double* b);

/// e += factor G x.
void add_loop_rows(const Component& component, double factor, const double* x, double* e);

}  // namespace cogrsim::dynamics
