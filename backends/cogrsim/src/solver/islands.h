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
// Normal block: the normals of one resting pair. Point i yields to its load beyond the mean of the k
// points: e = J v + b + gamma (l - sum l / k), so that A + gamma (1 - 1 1' / k) is inverted at once.
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

/// A row of an island. `numbers`: J and W of the first side, then those of the second.
struct IslandRow {
  const double* numbers = nullptr;
  int at[2] = {0, 0};        ///< first entry of a side among the island's speeds
  int size[2] = {0, 0};      ///< 0: no such side
  int set_row = 0;           ///< in RowSet::rows
  bool free_bodies = false;  ///< each of its sides is one free body
  double bias = 0.0, gamma = 0.0;
  double inverse = 0.0;   ///< 1 / (diagonal + gamma)
  double diagonal = 0.0;  ///< of A
  double low = 0.0, high = 0.0;
  double lambda = 0.0;
  double position_impulse = 0.0;  ///< warm start
};

/// Rows that are relaxed together.
struct RowBlock {
  enum class Kind { scalar, ball, contact } kind = Kind::scalar;
  int first_row = 0;
  int partner = 0;  ///< patch, twist: the normal of the other point
  FrictionKind friction_kind = FrictionKind::point;
  double friction = 0.0;  ///< ball: the bound
  double lever = 0.0;
  double rolling = 0.0, spinning = 0.0;  ///< as in ContactRows
  int turning = 0;                       ///< first of the rows against rolling and spinning
  int normal_block = -1;                 ///< solved before this contact's friction; -1: none
  bool in_normal_block = false;  ///< the normal has been solved with those of an earlier contact
};

/// The normals of a resting pair: one by one their shares of the load converge slowly, because each
/// point yields little (see README).
struct NormalBlock {
  static constexpr int kMost = 4;
  /// Fraction of the mean load that causes no compliance. Less than 1: where joints hold the points, the
  /// rest alone keeps the matrix regular.
  static constexpr double kMeanShare = 1.0 - 1e-6;
  int count = 0;
  int row[kMost] = {0, 0, 0, 0};
  double mean_compliance = 0.0;                 ///< kMeanShare gamma / count [1/kg]
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();  ///< J W' + gamma 1 - mean_compliance 1 1'
  Eigen::Matrix4d A_inverse = Eigen::Matrix4d::Zero();
};

/// Components that rows couple, and all their rows.
class Island {
 public:
  std::vector<IslandRow> rows;
  std::vector<RowBlock> blocks;  ///< joints' first
  std::size_t contacts = 0;      ///< where those of contacts begin
  std::vector<int> speeds;       ///< of each speed, where it is in arrays over all components
  std::vector<int> pairs;        ///< pair id of each contact's block
  std::vector<const Component*> components;
  std::vector<double> v;  ///< change of the speeds
  std::vector<double> p;  ///< displacement; empty: none

  void clear();
  /// Precomputes data for the sweeps. Call it after all rows and blocks are added.
  void prepare();
  /// Velocity stage, from the impulses in the rows, which are not in `v` yet, impact after impact.
  void solve_velocities(const SolverOptions& options, double h, std::vector<Row>& set_rows);
  /// Position stage, after the other: fills `p`, and the gaps in `set_rows`, the rows of all
  /// islands. `h` [s]: the step.
  void solve_positions(const SolverOptions& options, double h, std::vector<Row>& set_rows);

 private:
  int solve_velocities(const SolverOptions& options);
  // The same, with less restitution where impacts would add energy.
  void solve_impacts(const SolverOptions& options, const std::vector<Row>& set_rows);
  // One beyond the last row of a block.
  std::size_t end_of(std::size_t block) const {
    return block + 1 < blocks.size() ? std::size_t(blocks[block + 1].first_row) : rows.size();
  }
  bool impacts_add_energy(const std::vector<Row>& set_rows) const;
  // Takes up contacts that wait and are closed by what was solved; false: there is none.
  bool pass_impacts_on(double bounce_threshold, double h, bool last, std::vector<Row>& set_rows);
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
  double relax_contact(const RowBlock& block);
  template <class Rows>
  double relax_turning(const RowBlock& block);
  template <class Rows>
  double relax_ball(const RowBlock& block);
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
  bool measure_gaps(double h, std::vector<Row>& set_rows);
  void hold_sticking(double h);

  bool is_free_body_island_ = false;
  FreeBodyIsland free_body_island_;  ///< with is_free_body_island_: does all the work
  std::vector<NormalBlock> normal_blocks_;
  std::vector<Gap> gaps_;
  ConjugateSteps<double, double> steps_;
  std::vector<Row::Impact> impacts_;  ///< by row
  std::vector<double> start_, warm_;  ///< v and impulses before the impacts
  std::vector<double> earlier_;       ///< impulses of impacts that are over, by row
  std::vector<double> v0_;            ///< v without impulses
  enum class Part { all, loads, friction } part_ = Part::all;  ///< what a sweep relaxes of contacts
};

}  // namespace cogrsim::dynamics
