// Products of short vectors of any length, two entries at a time.
#pragma once

namespace cogrsim::dynamics {

/// A SIMD vector of two doubles, an extension of GCC and Clang; anywhere in an array.
using Pair = double __attribute__((vector_size(16), aligned(8), may_alias));

inline const Pair& pair_at(const double* x) { return *reinterpret_cast<const Pair*>(x); }
inline Pair& pair_at(double* x) { return *reinterpret_cast<Pair*>(x); }

/// a . b. Even and odd entries are summed separately: one sum alone waits for each addition.
inline double product(const double* a, const double* b, int size) {
  Pair sum = {}, other = {};
  int k = 0;
  for (; k + 3 < size; k += 4) {
    sum += pair_at(a + k) * pair_at(b + k);
    other += pair_at(a + k + 2) * pair_at(b + k + 2);
  }
  if (k + 1 < size) {
    sum += pair_at(a + k) * pair_at(b + k);
    k += 2;
  }
  sum += other;
  const double even = sum[0] + sum[1];
  return k < size ? even + a[k] * b[k] : even;
}

/// x += factor a.
inline void add_scaled(double factor, const double* a, int size, double* x) {
  int k = 0;
  for (; k + 3 < size; k += 4) {
    pair_at(x + k) += factor * pair_at(a + k);
    pair_at(x + k + 2) += factor * pair_at(a + k + 2);
  }
  if (k + 1 < size) {
    pair_at(x + k) += factor * pair_at(a + k);
    k += 2;
  }
  if (k < size) x[k] += factor * a[k];
}

/// x += factor_a a + factor_b b.
inline void add_two_scaled(double factor_a, const double* a, double factor_b, const double* b,
                           int size, double* x) {
  int k = 0;
  for (; k + 1 < size; k += 2)
    pair_at(x + k) += factor_a * pair_at(a + k) + factor_b * pair_at(b + k);
  if (k < size) x[k] += factor_a * a[k] + factor_b * b[k];
}

}  // namespace cogrsim::dynamics
