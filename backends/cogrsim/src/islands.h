// Mechanisms that rows tie together, solved each for itself: projected Gauss-Seidel.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "heap.h"
#include "rows.h"

namespace cogrsim::dynamics {

struct SolverOptions {
  int iterations = 60;      ///< at most, in each stage
  double tolerance = 1e-7;  ///< stop when no impulse changes a velocity by more [m/s], [rad/s]
};

/// A row as the sweeps need it. `numbers`: J and W of the first side, then those of the second.
struct Line {
  const double* numbers = nullptr;
  int at[2] = {0, 0};    ///< first entry of a side among the island's speeds
  int size[2] = {0, 0};  ///< 0: no such side
  int row = 0;
  bool lone = false;  ///< both sides, as far as there are, are of one free body each
  double bias = 0.0, gamma = 0.0, inverse = 0.0, diagonal = 0.0;
  double low = 0.0, high = 0.0;
  double lambda = 0.0;
  double push = 0.0;  ///< to start from
};

/// What is solved at once.
struct Block {
  enum class Kind { scalar, ball, contact } kind = Kind::scalar;
  int line = 0;     ///< the first of its lines
  int partner = 0;  ///< patch, twist: the normal of the other point
  FrictionKind friction_kind = FrictionKind::point;
  double friction = 0.0;  ///< ball: the bound
  double lever = 0.0;
  int bearing = -1;    ///< whose normals are solved before this contact's friction
  bool borne = false;  ///< the normal has been solved with those of an earlier contact
};

/// The normals of a resting pair, solved together: how they share the load converges slowly one by
/// one, because each point yields but little (see README).
struct Bearing {
  static constexpr int kMost = 4;
  /// To so much of the mean load no point yields. Not quite all: points that joints hold may have no
  /// other say in it.
  static constexpr double kShared = 1.0 - 1e-6;
  int count = 0;
  int line[kMost] = {0, 0, 0, 0};
  double shared = 0.0;  ///< each point yields to what it bears beyond the mean of all [1/kg]: this
                        ///< times their sum is taken off
  Eigen::Matrix4d response = Eigen::Matrix4d::Zero();  ///< J W^T and what the points yield
  Eigen::Matrix4d inverse = Eigen::Matrix4d::Zero();
};

/// Components that rows tie together, and all their rows.
class Island {
 public:
  std::vector<Line> lines;
  std::vector<Block> blocks;  ///< joints' first
  std::size_t contacts = 0;   ///< where those of contacts begin
  std::vector<int> speeds;    ///< of each speed, where it is in arrays over all components
  std::vector<int> pairs;     ///< of each contact's block, a number that those of one pair share
  std::vector<const Component*> components;
  std::vector<double> v;  ///< change of the speeds
  std::vector<double> p;  ///< displacement; empty: none

  void clear();
  /// Makes ready what the sweeps need. After all lines and blocks are there.
  void prepare();
  /// Velocity stage, from the impulses in the lines, which are not in `v` yet. Returns the sweeps.
  int solve_velocities(const SolverOptions& options);
  /// Position stage, after the other: fills `p` and the gaps of the rows in `rows`, all rows there
  /// are. `h` [s]: the step.
  void solve_positions(const SolverOptions& options, double h, std::vector<Row>& rows);

 private:
  void find_bearings();
  // A row with a gap, or one that must not slide: how far it is from its target, and the multiplier
  // of its displacement.
  struct Gap {
    int line = 0;
    bool pull = false;
    double error = 0.0, push = 0.0;
    double last = 0.0, along = 0.0;  // push before a pair of sweeps, and the conjugate step
  };

  // `Rows`: AnyRows or RowsOf, see islands.cpp.
  template <class Rows>
  int solve_velocities_of(const SolverOptions& options);
  template <class Rows>
  double relax_contact(const Block& block);
  template <class Rows>
  double relax_ball(const Block& block);
  template <class Rows>
  double relax_bearing(const Bearing& bearing);
  template <class Rows>
  double relax_two(const Bearing& bearing);
  template <class Rows>
  void apply_bearing(const Bearing& bearing, const Eigen::Vector4d& change);
  template <class Rows>
  double sweep(bool backwards);
  double go_on(double last_size);
  // Changes nothing where it does not find what makes all rows hold; see direct.cpp.
  void solve_directly(double tolerance);
  double go_on_settling(double last_size);
  bool measure_gaps(double h, std::vector<Row>& rows);
  void hold_sticking(double h);

  bool is_heap_ = false;
  Heap heap_;  ///< with is_heap_: does all the work
  std::vector<Bearing> bearings_;
  std::vector<Gap> gaps_;
  std::vector<double> last_lambda_, last_v_, along_lambda_, along_v_;
};

}  // namespace cogrsim::dynamics
