// Products of short vectors of any length, two entries at a time.
#pragma once

#include <Eigen/Core>

namespace cogrsim::simbody {

/// a . b. Even and odd entries are summed apart: one sum alone waits for each addition.
inline double product(const double* a, const double* b, int size) {
  using Read = Eigen::Map<const Eigen::Vector2d>;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int k = 0;
  for (; k + 1 < size; k += 2) sum += Read(a + k).cwiseProduct(Read(b + k));
  if (k < size) sum[0] += a[k] * b[k];
  return sum[0] + sum[1];
}

/// x += factor a.
inline void add_scaled(double factor, const double* a, int size, double* x) {
  int k = 0;
  for (; k + 1 < size; k += 2)
    Eigen::Map<Eigen::Vector2d>(x + k) += factor * Eigen::Map<const Eigen::Vector2d>(a + k);
  if (k < size) x[k] += factor * a[k];
}

}  // namespace cogrsim::simbody
