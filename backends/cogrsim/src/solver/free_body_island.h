// Large islands of free bodies: the same conditions as in Island, laid out for speed.
#pragma once

#include <cstddef>
#include <vector>

#include "solver/conjugate_steps.h"
#include "solver/rows.h"

namespace cogrsim::dynamics {

struct SolverOptions;

/// SIMD vectors of doubles, extensions of GCC and Clang. Each entry is computed by itself, so that
/// the results do not depend on how many of them the processor takes at a time. Structs that hold them
/// set their alignment: that of a Four alone depends on the instructions compiled for.
using Two = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));

/// Speeds of one body, scaled as Island::v.
struct alignas(64) FreeIslandBody {
  Four first;  ///< angular, and the first of the linear ones
  Two last;
};

/// Up to four rows of one pair of bodies, relaxed together.
struct alignas(32) FreeIslandGroup {
  enum class Kind {
    normals,       ///< each by itself
    normal_block,  ///< all at once, see NormalBlock
    point,         ///< the normal and two tangents of one point
    tangents       ///< two tangents each of one or two points
  };
  struct alignas(32) Row {
    Four a, last, b;  ///< of side a, of both, of side b; see FreeIslandBody
  };
  Row rows[4];
  Four below[3];  ///< Delassus entries: change of velocity of later rows per impulse in row i
  Four bias, gamma, inverse;
  int a = 0, b = 0;  ///< bodies
  Kind kind = Kind::normals;
  int count = 0;
  int normals = 0;       ///< tangents: the group of their normals
  int point = 0;         ///< tangents: which of its rows is the normal of the first point
  int normal_block = 0;  ///< its index
  double friction[2] = {0.0, 0.0};
};

/// The impulses of a group's rows, and their diagonal of A.
struct alignas(64) FreeIslandImpulses {
  Four lambda, diagonal;
};

/// The rows of a group in the position stage.
struct alignas(32) FreeIslandGaps {
  Four error, position_impulse, least;
  Four weight;   ///< 0: inactive
  Four yield;    ///< compliance, relative to the inverse mass
  Four hold;     ///< the weight without yielding, of what is held; else 0
  int rows = 0;  ///< up to the last active one
  bool held = false;
};

inline void take_conjugate_step(double beta, FreeIslandBody& v, FreeIslandBody& last,
                                FreeIslandBody& direction) {
  take_conjugate_step(beta, v.first, last.first, direction.first);
  take_conjugate_step(beta, v.last, last.last, direction.last);
}

/// Contacts of free bodies, nothing else.
class FreeBodyIsland {
 public:
  struct alignas(32) NormalBlock {
    Four A[4], A_inverse[4];
    Four share;          // w
    double gamma = 0.0;  // see NormalBlock
  };

  /// `bodies`: how many, of six speeds each.
  void fill(const std::vector<Row>& rows, const std::vector<ContactRows>& contacts, int bodies,
            double h);
  int solve_velocities(const SolverOptions& options, std::vector<Row>& rows,
                       std::vector<double>& v);
  void solve_positions(const SolverOptions& options, double h, std::vector<Row>& rows,
                       std::vector<double>& p);

 private:
  // Contacts of a pair.
  struct Touch {
    std::size_t first = 0;
    int count = 0;
    bool whole = true;  // they are all of the pair's
    bool bundled = false;
    int a = 0, b = 0;   // bodies; b -1: it does not move
    int normals = 0;    // their group
  };
  void find_touches(const std::vector<Row>& rows, const std::vector<ContactRows>& contacts);
  void add_normals(const std::vector<Row>& rows, const std::vector<ContactRows>& contacts,
                   Touch& touch);
  void add_tangents(const std::vector<Row>& rows, const std::vector<ContactRows>& contacts,
                    const Touch& touch, int point);
  FreeIslandGroup& add_group(const std::vector<Row>& rows, FreeIslandGroup::Kind kind,
                             const int* indices, int count);
  void add_normal_block();  // of the last group
  void load(const std::vector<double>& v, std::vector<FreeIslandBody>& out) const;
  void store(const std::vector<FreeIslandBody>& in, std::vector<double>& v) const;
  bool measure_gaps(double h, std::vector<Row>& rows);
  void hold_sticking(double h);

  // What does not move is one of several bodies behind the others, or what touches it would wait for one another.
  static constexpr int kUnmoved = 4;

  bool moves_ = false;
  int bodies_ = 0;
  std::vector<FreeIslandGroup> groups_;
  std::vector<FreeIslandImpulses> impulses_;  // by group
  // First groups of bundles, of which up to kBundle pairs have no body in common: a processor relaxes some at once.
  std::vector<int> bundles_;
  std::vector<NormalBlock> normal_blocks_;
  std::vector<Touch> touches_;
  std::vector<int> row_of_;  // four for each group; -1: none
  std::vector<FreeIslandGaps> gaps_;
  std::vector<FreeIslandBody> v_, p_;
  ConjugateSteps<Four, FreeIslandBody> steps_;
  std::vector<Four> found_;  ///< position impulses by group, before the last sweeps
};

}  // namespace cogrsim::dynamics
