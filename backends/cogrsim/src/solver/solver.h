// Impulses and displacements that make all rows hold, island by island.
#pragma once

#include <vector>

#include "cogrsim/core/worker_pool.h"
#include "solver/islands.h"

namespace cogrsim::dynamics {

/// Projected Gauss-Seidel, one contact at a time (normal, then friction on the disc of Coulomb);
/// Anitescu and Potra, Nonlinear Dynamics 14, 1997; Catto, GDC 2005. Sweeps alternate in direction.
/// Components that no row couples are solved independently, each with its own stopping test.
/// The normals of a resting pair are solved at once. Small islands take conjugate steps between
/// sweeps (after Silcowitz, Niebe and Erleben, The Visual Computer 26, 2010; they after every
/// sweep, we after each forward-backward pair of sweeps, a symmetric preconditioner).
/// Keeps only scratch memory between calls.
class Solver {
 public:
  /// Islands are solved on the threads of `pool`, if any: no result depends on their number.
  Solver(const SolverOptions& options, WorkerPool* pool) : options_(options), pool_(pool) {}

  /// Velocity stage: finds the impulses of all rows, starting from those in the rows, and adds what
  /// they do to `dv` (over all components), which must not include the warm-start impulses yet.
  /// Position stage ("split impulse"): displacements `p`, along W of the unilateral rows, that bring
  /// gaps at the end of the step `h` [s] to their targets. Adds no energy of motion. `p` is zero
  /// (over all components) before.
  void solve(RowSet& set, const std::vector<Component>& components, double h, double* dv,
             double* p);

 private:
  // Which island each component belongs to, and what each has of its kind.
  void partition(const RowSet& set);
  int find(int component);
  // Indices of things by island, in their order.
  struct ByIsland {
    std::vector<int> items, ends;
    // `island_of(i)`: of thing i of `count`.
    template <class IslandOf>
    void sort(std::size_t count, int islands, const IslandOf& island_of);
    struct Range {
      const int *first, *last;
      const int* begin() const { return first; }
      const int* end() const { return last; }
    };
    Range of(std::size_t island) const {
      const int begin = island == 0 ? 0 : ends[island - 1];
      return {items.data() + begin, items.data() + ends[island]};
    }
  };
  void fill_island(const RowSet& set, std::size_t number, Island& island);
  void solve_island(Island& island, RowSet& set, double h, double* dv, double* p) const;
  int add_row(const RowSet& set, int index, Island& island);

  SolverOptions options_;
  WorkerPool* pool_;
  const std::vector<Component>* components_ = nullptr;
  ByIsland scalars_, balls_, contacts_;  ///< joints' rows, balls' friction and contacts
  int count_ = 0;                        ///< of islands
  std::vector<int> root_, number_;       ///< by component
  std::vector<int> start_;               ///< by component: its first speed in the island
  std::vector<int> row_in_island_;       ///< by row: its index in Island::rows
};

}  // namespace cogrsim::dynamics
