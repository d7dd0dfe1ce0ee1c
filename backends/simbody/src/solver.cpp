#include "solver.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::simbody {
namespace {

constexpr int kPositionSweeps = 40;

// One row towards its target; returns the change of its velocity.
double relax(const RowSet& set, Row& row, double low, double high, double* dv) {
  const double residual =
      row.now + set.along(row, dv) + row.gamma * row.lambda - row.target;
  const double before = row.lambda;
  row.lambda = std::clamp(before - residual * row.inverse_diagonal, low, high);
  const double change = row.lambda - before;
  if (change == 0.0) return 0.0;
  set.apply(row, change, dv);
  return std::abs(change) * row.diagonal;
}

double relax_contact(RowSet& set, const ContactRows& contact, double* dv) {
  Row& normal = set.rows[std::size_t(contact.first)];
  double change = relax(set, normal, 0.0, normal.high, dv);
  if (contact.friction <= 0.0) return change;
  Row& t1 = set.rows[std::size_t(contact.first + 1)];
  double load = normal.lambda;
  if (contact.partner >= 0)
    load += set.rows[std::size_t(set.contacts[std::size_t(contact.partner)].first)].lambda;
  const double bound = contact.friction * load;
  if (contact.kind == FrictionKind::twist) {
    const double most = contact.lever * bound;
    return std::max(change, relax(set, t1, -most, most, dv));
  }
  Row& t2 = set.rows[std::size_t(contact.first + 2)];
  if (bound <= 0.0 && t1.lambda == 0.0 && t2.lambda == 0.0) return change;
  double l1 = t1.lambda - (t1.now + set.along(t1, dv)) * t1.inverse_diagonal;
  double l2 = t2.lambda - (t2.now + set.along(t2, dv)) * t2.inverse_diagonal;
  const double length = std::hypot(l1, l2);
  if (length > bound) {
    const double scale = length > 0.0 ? bound / length : 0.0;
    l1 *= scale;
    l2 *= scale;
  }
  const double d1 = l1 - t1.lambda, d2 = l2 - t2.lambda;
  t1.lambda = l1;
  t2.lambda = l2;
  if (d1 != 0.0) set.apply(t1, d1, dv);
  if (d2 != 0.0) set.apply(t2, d2, dv);
  return std::max({change, std::abs(d1) * t1.diagonal, std::abs(d2) * t2.diagonal});
}

double relax_ball(RowSet& set, const BallFriction& ball, double* dv) {
  Vec3 wanted, before;
  for (int k = 0; k < 3; ++k) {
    const Row& row = set.rows[std::size_t(ball.first + k)];
    before[k] = row.lambda;
    wanted[k] = row.lambda - (row.now + set.along(row, dv)) * row.inverse_diagonal;
  }
  const double length = wanted.norm();
  if (length > ball.bound) wanted *= ball.bound / length;
  double change = 0.0;
  for (int k = 0; k < 3; ++k) {
    Row& row = set.rows[std::size_t(ball.first + k)];
    const double d = wanted[k] - before[k];
    row.lambda = wanted[k];
    set.apply(row, d, dv);
    change = std::max(change, std::abs(d) * row.diagonal);
  }
  return change;
}

}  // namespace

int solve_velocities(const SolverOptions& options, RowSet& set, double* dv) {
  for (const Row& row : set.rows)
    if (row.lambda != 0.0) set.apply(row, row.lambda, dv);
  const int contacts = int(set.contacts.size());
  for (int sweep = 1; sweep <= options.iterations; ++sweep) {
    double change = 0.0;
    for (int index : set.scalars) {
      Row& row = set.rows[std::size_t(index)];
      change = std::max(change, relax(set, row, row.low, row.high, dv));
    }
    for (const BallFriction& ball : set.balls) change = std::max(change, relax_ball(set, ball, dv));
    for (int i = 0; i < contacts; ++i) {
      const int place = sweep % 2 ? i : contacts - 1 - i;
      change = std::max(change, relax_contact(set, set.contacts[std::size_t(place)], dv));
    }
    if (change < options.tolerance) return sweep;
  }
  return options.iterations;
}

void solve_positions(const SolverOptions& options, RowSet& set, const double* dv, double h,
                     double* p) {
  static thread_local std::vector<int> active;
  active.clear();
  bool needed = false;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    Row& row = set.rows[i];
    if (!row.has_gap) continue;
    row.gap += 0.5 * h * set.along(row, dv);
    row.pull = row.pull && row.lambda > 0.0;
    row.push = 0.0;
    active.push_back(int(i));
    const double error = row.gap_target - row.gap;
    if (error > 0.0 || (row.pull && error != 0.0)) needed = true;
  }
  if (!needed) return;
  // A velocity tolerance times the step is a displacement nobody sees.
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      Row& row = set.rows[std::size_t(active[sweep % 2 ? i : active.size() - 1 - i])];
      const double error = row.gap_target - row.gap - set.along(row, p);
      const double before = row.push;
      row.push = before + error / row.diagonal;
      if (!row.pull) row.push = std::max(row.push, 0.0);
      const double d = row.push - before;
      if (d == 0.0) continue;
      set.apply(row, d, p);
      change = std::max(change, std::abs(d) * row.diagonal);
    }
    if (change < tolerance) break;
  }
  for (int index : active) {
    Row& row = set.rows[std::size_t(index)];
    row.settled = set.along(row, p);
  }
}

}  // namespace cogrsim::simbody
