// Newton's method for islands of few rows that the sweeps leave unsolved, as those of large mass
// ratios.
//
// All rows (see islands.h) are one equation F(l) = 0, non-smooth where a bound begins to hold, with r
// the inverse of a row's own A_ii + gamma_i:
//
//   between bounds       F = l - clamp(l - r e, low, high)
//   in a disc or ball    F = l - w min(1, b / |w|),  w = l - r e,  b = mu (load) or fixed
//
// e = J v + b + C l, v = v0 + W' (l - l0), with C the compliance of rows and normal blocks. Newton's
// step with the generalized Jacobian D = dF/dl (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92,
// 1991) is shortened until the largest error, as a velocity, decreases. A result that has not converged
// is dropped.
#include <algorithm>
#include <cmath>

#include "solver/islands.h"
#include "solver/products.h"

namespace cogrsim::dynamics {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr int kNewtonSteps = 30;
constexpr double kShortest = 1e-3;  // of a Newton step
// Directions of less than this, relative to the largest, are left alone: forces that only press the
// points of a face against each other.
constexpr double kSingular = 1e-13;

}  // namespace

/// F, its derivative, and the error, for the rows of an island.
class Island::NewtonProblem {
 public:
  explicit NewtonProblem(const Island& island)
      : island_(island),
        rows_(island.rows),
        W_(Matrix::Zero(Eigen::Index(rows_.size()), Eigen::Index(island.v.size()))),
        start_(Eigen::Index(rows_.size())),
        scale_(Eigen::Index(rows_.size())),
        F_(Eigen::Index(rows_.size())) {
    const Eigen::Index m = W_.rows(), n = W_.cols();
    Matrix J = Matrix::Zero(m, n);
    Vector bias(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Row& row = rows_[std::size_t(i)];
      for (int s = 0; s < 2; ++s) {
        for (int k = 0; k < row.size[s]; ++k) {
          J(i, row.at[s] + k) = row.j(s)[k];
          W_(i, row.at[s] + k) = row.w(s)[k];
        }
      }
      start_[i] = row.lambda;
      bias[i] = row.bias;
      scale_[i] = row.inverse > 0.0 ? 1.0 / row.inverse : 0.0;
    }
    A_ = J * W_.transpose();
    e0_ = bias + J * Eigen::Map<const Vector>(island.v.data(), n) - A_ * start_;
    for (Eigen::Index i = 0; i < m; ++i) A_(i, i) += rows_[std::size_t(i)].gamma;
    for (const NormalBlock& block : island.normal_blocks_)
      for (int i = 0; i < block.count; ++i)
        for (int k = 0; k < block.count; ++k)
          A_(block.row[i], block.row[k]) -= block.gamma * block.share[i] * block.share[k];
  }

  const Vector& start() const { return start_; }
  const Vector& residual() const { return F_; }
  const Matrix& derivative() const { return D_; }
  /// Change of the island's speeds.
  Vector speed_change(const Vector& l) const { return W_.transpose() * (l - start_); }

  /// Fills F and, when wanted, D; returns the largest error [m/s].
  double evaluate(const Vector& l, bool derivatives) {
    e_ = e0_ + A_ * l;
    derivatives_ = derivatives;
    if (derivatives) D_ = Matrix::Zero(A_.rows(), A_.rows());
    const auto bounded = [&](int row) {
      evaluate_bounds(l, row, rows_[std::size_t(row)].low, rows_[std::size_t(row)].high);
    };
    for (const int row : island_.scalars) bounded(row);
    for (const BallFriction& ball : island_.balls)
      evaluate_disc(l, ball.first, 3, ball.bound, nullptr, 0);
    for (const ContactRows& contact : island_.contacts) {
      bounded(contact.first);
      evaluate_friction(l, contact);
    }
    return F_.cwiseProduct(scale_).cwiseAbs().maxCoeff();
  }

 private:
  double inverse(Eigen::Index i) const { return rows_[std::size_t(i)].inverse; }

  void evaluate_bounds(const Vector& l, Eigen::Index i, double low, double high) {
    const double w = l[i] - inverse(i) * e_[i];
    F_[i] = l[i] - std::clamp(w, low, high);
    if (!derivatives_) return;
    if (w > low && w < high)
      D_.row(i) = inverse(i) * A_.row(i);
    else
      D_(i, i) = 1.0;
  }

  void evaluate_friction(const Vector& l, const ContactRows& contact) {
    const int row = contact.first, count = contact.partner < 0 ? 1 : 2;
    const int loads[2] = {
        row, count == 1 ? row : island_.contacts[std::size_t(contact.partner)].first};
    const bool twist = contact.kind == FrictionKind::twist;
    if (contact.friction > 0.0)
      evaluate_disc(l, row + 1, contact.friction_rows(),
                    contact.friction * (twist ? contact.lever : 1.0), loads, count);
    if (contact.rolling > 0.0)
      evaluate_disc(l, contact.first_turning(), 2, contact.rolling, loads, 1);
    if (contact.spinning > 0.0)
      evaluate_disc(l, contact.end() - 1, 1, contact.spinning, loads, 1);
  }

  // `loads`: rows whose sum times `factor` is the bound; none: `factor` itself is.
  void evaluate_disc(const Vector& l, Eigen::Index first, int size, double factor, const int* loads,
                     int count) {
    double bound = factor;
    if (count > 0) {
      double load = 0.0;
      for (int k = 0; k < count; ++k) load += l[loads[k]];
      bound = factor * std::max(load, 0.0);
    }
    const Vector r = inverse(first) * Vector::Ones(size);
    const Vector w = l.segment(first, size) - r.cwiseProduct(e_.segment(first, size));
    const double length = w.norm();
    const bool sticks = length <= bound;
    F_.segment(first, size) = l.segment(first, size) - (sticks ? w : Vector(w * (bound / length)));
    if (!derivatives_) return;
    Matrix dw = -(r.asDiagonal() * A_.middleRows(first, size));
    dw.middleCols(first, size) += Matrix::Identity(size, size);
    if (!sticks) {
      const Vector along = w / length;
      dw = ((bound / length) * (dw - along * (along.transpose() * dw))).eval();
      for (int k = 0; k < count; ++k)
        if (bound > 0.0) dw.col(loads[k]) += factor * along;
    }
    D_.middleRows(first, size) = -dw;
    D_.block(first, first, size, size) += Matrix::Identity(size, size);
  }

  const Island& island_;
  const std::vector<Row>& rows_;
  Matrix W_, A_, D_;  // A with the compliance C
  Vector start_, scale_, e0_, e_, F_;
  bool derivatives_ = false;
};

bool Island::solve_directly(double tolerance) {
  NewtonProblem problem(*this);
  Vector l = problem.start();
  double error = problem.evaluate(l, true);
  for (int step = 0; step < kNewtonSteps && error > tolerance; ++step) {
    Eigen::CompleteOrthogonalDecomposition<Matrix> solver(l.size(), l.size());
    solver.setThreshold(kSingular);
    solver.compute(problem.derivative());
    const Vector direction = solver.solve(problem.residual());
    double share = 1.0;
    for (; share > kShortest; share *= 0.5)
      if (problem.evaluate(l - share * direction, false) < error) break;
    if (share <= kShortest) break;
    l -= share * direction;
    error = problem.evaluate(l, true);
  }
  if (!(error <= tolerance)) return false;
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].lambda = l[Eigen::Index(i)];
  Eigen::Map<Vector>(v.data(), Eigen::Index(v.size())) += problem.speed_change(l);
  return true;
}

}  // namespace cogrsim::dynamics
