// Islands: mechanisms coupled by constraint rows, each solved by itself with projected Gauss-Seidel.
//
// Velocity stage. With v (n) the change of the island's speeds over the step, v0 without impulses,
// J (m x n) its rows, M the mass matrix, W = J M^-1 and l (m) the impulses, find
//
//   v = v0 + W' l,   e = J v + b + Gamma l,   low <= l <= high,   e = 0 where l is between its bounds,
//
// e <= 0 at the upper bound and e >= 0 at the lower one. b = J u - target [m/s], Gamma = diag(gamma)
// the compliance of the rows [1/kg]. Relaxing row i: l_i := clamp(l_i - e_i / (A_ii + gamma_i)), with
// A = J W' the effective inverse mass. Friction of a point: the two tangents' l lie in the disc of
// radius mu l_n; those against rolling and spinning are bounded likewise, by a length times l_n.
//
// Position stage. With p the displacement of the speeds' coordinates and s its multipliers (position
// impulses), p = W' s: every gap g + J p is brought to its target, s >= 0 unless the row is bilateral.
//
// Impacts. Bodies that touch when an impact comes feel it at once. Those with a gap between them, of less than
// their way in the step, are hit by what the impact has made of the others: one generation of impacts after the
// other, each by Newton's law, w+ = -e w-, so that with e = 1 each keeps the energy. A contact that may be
// hit waits, without impulse, until it is. With friction Newton's law may add energy (Stronge, Impact mechanics, 2000):
// then the impacts of the island bounce with the largest part of e, of 32, that adds none.
//
// Normal block: the normals of one resting pair. Its points yield to what of their loads l is not shared among them
// as in the step before, w (|w| = 1), mixed with equal shares: e = J v + b + gamma (1 - w w') l, so that
// A + gamma (1 - w w') is inverted at once. What hangs over presses one side for ever, and does not sink there.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "solver/conjugate_steps.h"
#include "solver/free_body_island.h"
#include "solver/rows.h"

namespace cogrsim::dynamics {

struct SolverOptions {
  int iterations = 60;      ///< at most, in each stage
  double tolerance = 1e-7;  ///< stop when no impulse changes a velocity by more [m/s], [rad/s]
  double bounce_threshold = 0.05;  ///< impacts that are slower do not bounce [m/s]
};

/// The normals of a resting pair: one by one their shares of the load converge slowly, because each
/// point yields little (see README).
struct NormalBlock {
  static constexpr int kMost = 4;
  /// Fraction of the load along w that causes no compliance. Less than 1: where joints hold the points, the
  /// rest alone keeps the matrix regular.
  static constexpr double kFree = 1.0 - 1e-6;
  /// How much of w is equal shares: loads that only press the points against each other fade in as many steps.
  static constexpr double kEqual = 0.02;
  int count = 0;
  int row[kMost] = {0, 0, 0, 0};
  double gamma = 0.0;                               ///< kFree gamma [1/kg]
  Eigen::Vector4d share = Eigen::Vector4d::Zero();  ///< w
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();      ///< J W' + gamma 1 - kFree gamma w w'
  Eigen::Matrix4d A_inverse = Eigen::Matrix4d::Zero();
};

/// w of a normal block, from the loads of the step before.
Eigen::Vector4d load_shares(const Eigen::Vector4d& loads, int count);

/// Components that rows couple, and all their rows, those of joints first.
class Island : public RowSet {
 public:
  std::vector<const Component*> components;
  int speeds = 0;         ///< of the components, one after the other
  std::vector<double> v;  ///< change of the speeds
  std::vector<double> p;  ///< displacement; empty: none

  void clear();
  /// After all rows are added, gives them places among the speeds; `start`: of each of `all`, -1 before it has one.
  void place_rows(const std::vector<Component>& all, std::vector<int>& start);
  /// Speeds by u index, as those of the island: `v` or `p`. Those of a free body are root^-1 of the others, with
  /// M^-1 = root root', so that W = J.
  void scale(const double* all, std::vector<double>& out) const;
  void unscale(const std::vector<double>& in, double* all) const;
  /// Velocity stage, from the impulses in the rows, which are not in `v` yet, impact after impact.
  void solve_velocities(const SolverOptions& options, double h);
  /// Position stage, after the other: fills `p`, and the gaps in the rows. `h` [s]: the step.
  void solve_positions(const SolverOptions& options, double h);
  /// Of the rows with a gap, from displacements by u index.
  void measure_gap_changes(const double* displacement);

 private:
  // Precomputes data for the sweeps.
  void prepare(double h);
  int solve_velocities(const SolverOptions& options);
  // The same, with less restitution where impacts would add energy.
  void solve_impacts(const SolverOptions& options, double h);
  bool impacts_add_energy() const;
  // Takes up contacts that wait and are closed by what was solved; false: there is none.
  bool pass_impacts_on(double bounce_threshold, double h, bool last);
  void make_normal_blocks();
  // A row with a gap, or one that sticks: how far it is from its target, and the multiplier
  // of its displacement.
  struct Gap {
    int row = 0;
    bool bilateral = false;
    double error = 0.0, position_impulse = 0.0;
  };

  // `Rows`: AnyRows or RowsOf, see islands.cpp.
  template <class Rows>
  int solve_velocities_of(const SolverOptions& options);
  template <class Rows>
  int solve_together(const SolverOptions& options);
  template <class Rows>
  void solve_by_turns(const SolverOptions& options);
  template <class Rows>
  bool is_worse_than_none() const;
  template <class Rows>
  double relax_contact(const ContactRows& contact);
  template <class Rows>
  double relax_turning(const ContactRows& contact);
  template <class Rows>
  double relax_ball(const BallFriction& ball);
  template <class Rows>
  double relax_normal_block(const NormalBlock& normal_block);
  template <class Rows>
  double relax_two_normals(const NormalBlock& normal_block);
  template <class Rows>
  void apply_normal_block(const NormalBlock& normal_block, const Eigen::Vector4d& change);
  template <class Rows>
  double sweep(bool backwards);
  // Changes nothing where it does not converge; see direct.cpp.
  class NewtonProblem;
  bool solve_directly(double tolerance);
  bool measure_gaps(double h);
  bool hold_sticking(double h);

  bool is_free_body_island_ = false;
  FreeBodyIsland free_body_island_;  ///< with is_free_body_island_: does all the work
  std::vector<NormalBlock> normal_blocks_;
  std::vector<Gap> gaps_;
  ConjugateSteps<double, double> steps_;
  std::vector<double> start_, warm_;  ///< v and impulses before the impacts
  std::vector<double> earlier_;       ///< impulses of impacts that are over, by row
  std::vector<double> v0_;            ///< v without impulses
  enum class Part { all, loads, friction } part_ = Part::all;  ///< what a sweep relaxes of contacts
};

}  // namespace cogrsim::dynamics
