#include "mechanism/loops.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mechanism/mechanism.h"
#include "solver/products.h"

namespace cogrsim::dynamics {
namespace {

// A row of which less than this, relative to the largest of its kind in its weld, is left beside the
// rows before it adds nothing.
constexpr double kDependent = 1e-9;

struct Ends {
  const LinkMotion& shadow;
  const LinkMotion& primary;
};
Ends ends_of(const Mechanism& mechanism, const Weld& weld) {
  return {mechanism.motions()[std::size_t(weld.shadow)],
          mechanism.motions()[std::size_t(weld.primary)]};
}

void write_spatial(const Vec3& angular, const Vec3& linear, double* e) {
  Eigen::Map<Vec3>{e} = angular;
  Eigen::Map<Vec3>{e + 3} = linear;
}

// Where the ranges of two welds meet.
struct Overlap {
  int first, size;
};
Overlap overlap(const Weld& a, const Weld& b) {
  const int first = std::max(a.first, b.first);
  return {first, std::min(a.end, b.end) - first};
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// Of the three rows against turning [1/rad] and of the three against shifting [1/m].
using RowScale = std::array<double, 2>;

// Fills the rows G and W of a weld; returns its own block of A = G M^-1 G'.
Matrix6 fill_weld_rows(const Mechanism& mechanism, Component& c, std::size_t w) {
  Loops& loops = c.linkage->loops;
  const Weld& weld = c.linkage->welds[w];
  const Vec3 r = ends_of(mechanism, weld).shadow.X.p - c.origin;
  Matrix6 A;
  for (int axis = 0; axis < 6; ++axis) {
    const Vec3 d = Vec3::Unit(axis % 3);
    const Spatial wrench = axis < 3 ? Spatial{d, Vec3::Zero()} : Spatial{r.cross(d), d};
    double* const g = loops.G.row(Eigen::Index(6 * w) + axis).data();
    double* const response = loops.W.row(Eigen::Index(6 * w) + axis).data();
    fill_row(c, weld.shadow_at, wrench, 1.0, g);
    fill_row(c, weld.primary_at, wrench, -1.0, g);
    std::copy(g + weld.first, g + weld.end, response + weld.first);
    solve_mass(c, response, weld.shadow_at);
    if (c.linkage->tree[std::size_t(weld.shadow_at)] !=
        c.linkage->tree[std::size_t(weld.primary_at)])
      solve_mass(c, response, weld.primary_at);
    for (int k = 0; k <= axis; ++k)
      A(axis, k) = A(k, axis) = product(loops.G.row(Eigen::Index(6 * w) + k).data() + weld.first,
                                        response + weld.first, weld.end - weld.first);
  }
  return A;
}

// Turns and shifts have different units: scales A so that the largest diagonal of each kind is 1.
RowScale normalize(Matrix6& A) {
  RowScale scale;
  for (int kind = 0; kind < 2; ++kind) {
    const double most = A.diagonal().segment<3>(3 * kind).maxCoeff();
    scale[std::size_t(kind)] = most > 0.0 ? 1.0 / std::sqrt(most) : 0.0;
  }
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) A(i, k) *= scale[std::size_t(i / 3)] * scale[std::size_t(k / 3)];
  return scale;
}

// Eliminates the independent rows of earlier welds: fills the six rows' entries of the factor in their
// columns (`head`, 6 rows of 6 nweld) and subtracts these from A, which becomes the Schur complement.
// Returns the first column that is not zero.
int eliminate_earlier_rows(const Component& c, std::size_t w, const RowScale& scale, double* head,
                           Matrix6& A) {
  const Loops& loops = c.linkage->loops;
  const Weld& weld = c.linkage->welds[w];
  const std::size_t stride = 6 * c.linkage->welds.size();
  const int before = int(loops.independent.size());
  int lead = before;
  for (int k = before; k-- > 0;)
    if (overlap(weld, c.linkage->welds[std::size_t(loops.independent[std::size_t(k)].weld)]).size >
        0)
      lead = k;
  for (int i = 0; i < 6; ++i) {
    double* const l = head + std::size_t(i) * stride;
    const double* const g = loops.G.row(Eigen::Index(6 * w) + i).data();
    for (int k = lead; k < before; ++k) {
      const Loops::IndependentRow& other = loops.independent[std::size_t(k)];
      const Overlap both = overlap(weld, c.linkage->welds[std::size_t(other.weld)]);
      double a = 0.0;
      if (both.size > 0)
        a = scale[std::size_t(i / 3)] * other.scale *
            product(g + both.first, loops.W.row(other.row).data() + both.first, both.size);
      const double* const ok = &loops.factor[std::size_t(k) * stride];
      const int from = std::max(lead, other.lead);
      l[k] = (a - product(ok + from, l + from, k - from)) * ok[k];
    }
    for (int k = 0; k <= i; ++k) {
      A(i, k) -= product(l + lead, head + std::size_t(k) * stride + lead, before - lead);
      A(k, i) = A(i, k);
    }
  }
  return lead;
}

// Appends the weld's independent rows to the factor, the largest pivot of the Schur complement first.
void append_independent_rows(Component& c, std::size_t w, const RowScale& scale, int lead,
                             const double* head, Matrix6& A) {
  Loops& loops = c.linkage->loops;
  const std::size_t stride = 6 * c.linkage->welds.size();
  const int before = int(loops.independent.size());
  std::array<std::array<double, 6>, 6> own{};  // the six rows' entries in the new columns
  std::array<bool, 6> taken{};
  for (int count = 0; count < 6; ++count) {
    int best = -1;
    for (int i = 0; i < 6; ++i)
      if (!taken[std::size_t(i)] && (best < 0 || A(i, i) > A(best, best))) best = i;
    if (!(A(best, best) > kDependent)) break;
    taken[std::size_t(best)] = true;
    const double inverse = 1.0 / std::sqrt(A(best, best));
    for (int i = 0; i < 6; ++i) own[std::size_t(i)][std::size_t(count)] = A(i, best) * inverse;
    const int column = before + count;
    double* const l = &loops.factor[std::size_t(column) * stride];
    std::copy_n(head + std::size_t(best) * stride + std::size_t(lead), before - lead, l + lead);
    std::copy_n(own[std::size_t(best)].data(), count, l + before);
    l[column] = inverse;
    loops.independent.push_back({int(w), int(6 * w) + best, lead, scale[std::size_t(best / 3)]});
    for (int i = 0; i < 6; ++i)
      for (int k = 0; k < 6; ++k)
        A(i, k) -=
            own[std::size_t(i)][std::size_t(count)] * own[std::size_t(k)][std::size_t(count)];
  }
}

}  // namespace

void update_loops(const Mechanism& mechanism, Component& c) {
  const std::size_t nweld = c.linkage->welds.size();
  Loops& loops = c.linkage->loops;
  loops.G.setZero(Eigen::Index(6 * nweld), c.size());
  loops.W.setZero(Eigen::Index(6 * nweld), c.size());
  loops.factor.resize(36 * nweld * nweld);
  loops.independent.clear();
  static thread_local std::vector<double> head;
  head.resize(36 * nweld);
  for (std::size_t w = 0; w < nweld; ++w) {
    Matrix6 A = fill_weld_rows(mechanism, c, w);
    const RowScale scale = normalize(A);
    const int lead = eliminate_earlier_rows(c, w, scale, head.data(), A);
    append_independent_rows(c, w, scale, lead, head.data(), A);
  }
}

void close_loops(const Component& c, double* x, const double* wanted) {
  if (!c.has_loops()) return;
  const Loops& loops = c.linkage->loops;
  const int count = int(loops.independent.size());
  const std::size_t stride = 6 * c.linkage->welds.size();
  static thread_local std::vector<double> impulse;
  impulse.resize(std::size_t(count));
  double* const l = impulse.data();
  for (int i = 0; i < count; ++i) {
    const Loops::IndependentRow& independent = loops.independent[std::size_t(i)];
    const Weld& weld = c.linkage->welds[std::size_t(independent.weld)];
    double value = product(loops.G.row(independent.row).data() + weld.first, x + weld.first,
                           weld.end - weld.first);
    if (wanted) value -= wanted[independent.row];
    const double* const row = &loops.factor[std::size_t(i) * stride];
    l[i] = (independent.scale * value -
            product(row + independent.lead, l + independent.lead, i - independent.lead)) *
           row[i];
  }
  for (int i = count; i-- > 0;) {
    const Loops::IndependentRow& independent = loops.independent[std::size_t(i)];
    const Weld& weld = c.linkage->welds[std::size_t(independent.weld)];
    const double* const row = &loops.factor[std::size_t(i) * stride];
    l[i] *= row[i];
    add_scaled(-l[i], row + independent.lead, i - independent.lead, l + independent.lead);
    add_scaled(-l[i] * independent.scale, loops.W.row(independent.row).data() + weld.first,
               weld.end - weld.first, x + weld.first);
  }
}

double find_loop_gaps(const Mechanism& mechanism, const Component& c, double* e) {
  double most = 0.0;
  for (std::size_t w = 0; w < c.linkage->welds.size(); ++w) {
    const Ends ends = ends_of(mechanism, c.linkage->welds[w]);
    const Eigen::AngleAxisd turn(ends.shadow.X.R * ends.primary.X.R.transpose());
    // Of a small angle only the skew part keeps its digits.
    const Mat3 R = ends.shadow.X.R * ends.primary.X.R.transpose();
    const Vec3 skew(0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)),
                    0.5 * (R(1, 0) - R(0, 1)));
    const Vec3 angular = skew.norm() < 1e-3 ? skew : Vec3(turn.angle() * turn.axis());
    const Vec3 shift = ends.shadow.X.p - ends.primary.X.p;
    write_spatial(angular, shift, e + 6 * w);
    most = std::max({most, angular.cwiseAbs().maxCoeff(), shift.cwiseAbs().maxCoeff()});
  }
  return most;
}

void find_loop_speeds(const Mechanism& mechanism, const Component& c, double* e) {
  for (std::size_t w = 0; w < c.linkage->welds.size(); ++w) {
    const Ends ends = ends_of(mechanism, c.linkage->welds[w]);
    write_spatial(ends.shadow.angular - ends.primary.angular,
                  ends.shadow.linear - ends.primary.velocity_at(ends.shadow.X.p), e + 6 * w);
  }
}

void find_loop_bias(const Mechanism& mechanism, const Component& c, double* b) {
  for (std::size_t w = 0; w < c.linkage->welds.size(); ++w) {
    const Weld& weld = c.linkage->welds[w];
    const Ends ends = ends_of(mechanism, weld);
    const Vec3 at = ends.shadow.X.p;
    write_spatial(
        c.linkage->bias[std::size_t(weld.shadow_at)].angular -
            c.linkage->bias[std::size_t(weld.primary_at)].angular,
        bias_at(c, weld.shadow_at, ends.shadow, at) - bias_at(c, weld.primary_at, ends.primary, at),
        b + 6 * w);
  }
}

void add_loop_rows(const Component& c, double factor, const double* x, double* e) {
  for (std::size_t w = 0; w < c.linkage->welds.size(); ++w) {
    const Weld& weld = c.linkage->welds[w];
    for (std::size_t i = 6 * w; i < 6 * w + 6; ++i)
      e[i] += factor * product(c.linkage->loops.G.row(Eigen::Index(i)).data() + weld.first,
                               x + weld.first, weld.end - weld.first);
  }
}

}  // namespace cogrsim::dynamics
