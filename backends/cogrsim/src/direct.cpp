// Islands of few rows that the sweeps leave undone, as those of large mass ratios: Newton's method.
#include <algorithm>
#include <cmath>

#include "islands.h"
#include "products.h"

namespace cogrsim::dynamics {
namespace {

constexpr int kNewtonSteps = 30;
constexpr double kShortest = 1e-3;  // of a Newton step
// Directions in which the rows say less than this of the most are left alone: forces that only press
// the points of a face against each other.
constexpr double kSayNothing = 1e-13;

}  // namespace

// All rows as one equation F(l) = 0, non-smooth where a bound begins to hold, with r the inverse of a
// row's own response:
//   between bounds   F = l - clamp(l - r e, low, high)
//   in a disc or ball F = l - w min(1, b / |w|),  w = l - r e,  b = mu (load) or fixed
// e = J v + what the row yields + bias, v = v0 + W (l - l0). Newton's step with the generalized
// Jacobian of where l is (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991), shortened
// until the largest error, as a velocity, gets less. What does not converge is dropped.
void Island::solve_directly(double tolerance) {
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;
  const Eigen::Index rows = Eigen::Index(lines.size()), freedoms = Eigen::Index(v.size());
  Matrix J = Matrix::Zero(rows, freedoms), W = Matrix::Zero(rows, freedoms);
  Vector start(rows), bias(rows), scale(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Line& line = lines[std::size_t(i)];
    const double* numbers = line.numbers;
    for (int s = 0; s < 2; ++s) {
      for (int k = 0; k < line.size[s]; ++k) {
        J(i, line.at[s] + k) = numbers[k];
        W(i, line.at[s] + k) = numbers[line.size[s] + k];
      }
      numbers += 2 * line.size[s];
    }
    start[i] = line.lambda;
    bias[i] = line.bias;
    scale[i] = line.inverse > 0.0 ? 1.0 / line.inverse : 0.0;
  }
  Matrix A = J * W.transpose();
  Vector at_zero = bias + J * Eigen::Map<const Vector>(v.data(), freedoms) - A * start;
  for (Eigen::Index i = 0; i < rows; ++i) A(i, i) += lines[std::size_t(i)].gamma;
  for (const Bearing& bearing : bearings_)
    for (int i = 0; i < bearing.count; ++i)
      for (int k = 0; k < bearing.count; ++k) A(bearing.line[i], bearing.line[k]) -= bearing.shared;

  Vector F(rows);
  Matrix D;
  // Fills F and, when wanted, D = dF/dl; returns the largest error [m/s].
  const auto evaluate = [&](const Vector& l, bool derivatives) {
    const Vector e = at_zero + A * l;
    if (derivatives) D = Matrix::Zero(rows, rows);
    const auto inverse = [&](Eigen::Index i) { return lines[std::size_t(i)].inverse; };
    const auto clamp = [&](Eigen::Index i, double low, double high) {
      const double w = l[i] - inverse(i) * e[i];
      F[i] = l[i] - std::clamp(w, low, high);
      if (!derivatives) return;
      if (w > low && w < high)
        D.row(i) = inverse(i) * A.row(i);
      else
        D(i, i) = 1.0;
    };
    // `loads`: rows whose sum bounds these, by `factor`; none: `factor` itself does.
    const auto disc = [&](Eigen::Index first, int size, double factor, const int* loads,
                          int count) {
      double bound = factor;
      if (count > 0) {
        double load = 0.0;
        for (int k = 0; k < count; ++k) load += l[loads[k]];
        bound = factor * std::max(load, 0.0);
      }
      const Vector r = inverse(first) * Vector::Ones(size);
      const Vector w = l.segment(first, size) - r.cwiseProduct(e.segment(first, size));
      const double length = w.norm();
      const bool sticks = length <= bound;
      F.segment(first, size) = l.segment(first, size) - (sticks ? w : Vector(w * (bound / length)));
      if (!derivatives) return;
      Matrix dw = -(r.asDiagonal() * A.middleRows(first, size));
      dw.middleCols(first, size) += Matrix::Identity(size, size);
      if (!sticks) {
        const Vector along = w / length;
        dw = ((bound / length) * (dw - along * (along.transpose() * dw))).eval();
        for (int k = 0; k < count; ++k)
          if (bound > 0.0) dw.col(loads[k]) += factor * along;
      }
      D.middleRows(first, size) = -dw;
      D.block(first, first, size, size) += Matrix::Identity(size, size);
    };
    for (const Block& block : blocks) {
      const int line = block.line;
      if (block.kind == Block::Kind::ball) {
        disc(line, 3, block.friction, nullptr, 0);
        continue;
      }
      clamp(line, lines[std::size_t(line)].low, lines[std::size_t(line)].high);
      if (block.kind != Block::Kind::contact || block.friction <= 0.0) continue;
      const int loads[2] = {line, block.partner};
      if (block.friction_kind == FrictionKind::point)
        disc(line + 1, 2, block.friction, loads, 1);
      else if (block.friction_kind == FrictionKind::patch)
        disc(line + 1, 2, block.friction, loads, 2);
      else
        disc(line + 1, 1, block.friction * block.lever, loads, 2);
    }
    return F.cwiseProduct(scale).cwiseAbs().maxCoeff();
  };

  Vector l = start;
  double error = evaluate(l, true);
  for (int step = 0; step < kNewtonSteps && error > tolerance; ++step) {
    Eigen::CompleteOrthogonalDecomposition<Matrix> solver(rows, rows);
    solver.setThreshold(kSayNothing);
    solver.compute(D);
    const Vector way = solver.solve(F);
    double share = 1.0;
    for (; share > kShortest; share *= 0.5)
      if (evaluate(l - share * way, false) < error) break;
    if (share <= kShortest) break;
    l -= share * way;
    error = evaluate(l, true);
  }
  if (!(error <= tolerance)) return;
  for (Eigen::Index i = 0; i < rows; ++i) lines[std::size_t(i)].lambda = l[i];
  Eigen::Map<Vector>(v.data(), freedoms) += W.transpose() * (l - start);
}

}  // namespace cogrsim::dynamics
