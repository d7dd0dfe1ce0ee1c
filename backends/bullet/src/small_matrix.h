// A symmetric matrix of up to sixteen rows, and its inverse, two entries at a time.
#pragma once

#include <array>
#include <type_traits>

#include "step_bodies.h"

namespace cogrsim::bullet {

/// Rows lie one after the other, filled up with zeros to an even length.
class SmallMatrix {
 public:
  static constexpr int kMost = 16;  ///< rows

  void resize(int rows) {
    rows_ = rows;
    pairs_ = (rows + 1) / 2;
    entries_.fill(Pair{});
  }
  double& at(int row, int column) {
    return reinterpret_cast<double*>(&entries_[place(row)])[column];
  }
  /// Becomes the inverse of the positive definite matrix it is (Gauss-Jordan in place). A row whose
  /// pivot falls below the part `dependent` of its diagonal depends on those before: it is left out,
  /// its row and column of the inverse are nil.
  void invert(double dependent) {
    with_pairs([&](auto pairs) { invert<pairs>(dependent); });
  }
  /// x := this x.
  void multiply(double* x) const {
    with_pairs([&](auto pairs) { multiply<pairs>(x); });
  }

 private:
  std::size_t place(int row) const { return static_cast<std::size_t>(row * pairs_); }
  template <int kPairs>
  void invert(double dependent);
  template <int kPairs>
  void multiply(double* x) const;
  /// Loops of a length known to the compiler are written out by it.
  template <class Call>
  void with_pairs(Call&& call) const;

  int rows_ = 0, pairs_ = 0;
  std::array<Pair, kMost * kMost / 2> entries_;
};

template <int kPairs>
void SmallMatrix::invert(double dependent) {
  std::array<double, kMost> diagonal;
  for (int k = 0; k < rows_; ++k) diagonal[static_cast<std::size_t>(k)] = at(k, k);
  for (int k = 0; k < rows_; ++k) {
    Pair* const pivot_row = &entries_[place(k)];
    const double pivot = at(k, k);
    if (pivot <= dependent * diagonal[static_cast<std::size_t>(k)]) {
      for (int j = 0; j < kPairs; ++j) pivot_row[j] = Pair{};
      for (int i = 0; i < rows_; ++i) at(i, k) = 0.0;
      continue;
    }
    at(k, k) = 1.0;
    Pair scaled[kPairs];
    for (int j = 0; j < kPairs; ++j) pivot_row[j] = scaled[j] = pivot_row[j] * (1.0 / pivot);
    for (int i = 0; i < rows_; ++i) {
      if (i == k) continue;
      Pair* const row = &entries_[place(i)];
      const double factor = at(i, k);
      at(i, k) = 0.0;
      for (int j = 0; j < kPairs; ++j) row[j] -= scaled[j] * factor;
    }
  }
}

template <int kPairs>
void SmallMatrix::multiply(double* x) const {
  Pair sums[kPairs] = {};
  // By columns, which are the rows.
  const Pair* column = entries_.data();
  for (int j = 0; j < rows_; ++j, column += kPairs) {
    for (int i = 0; i < kPairs; ++i) sums[i] += column[i] * x[j];
  }
  for (int i = 0; i < rows_; ++i) x[i] = sums[i / 2][i % 2];
}

template <class Call>
void SmallMatrix::with_pairs(Call&& call) const {
  switch (pairs_) {
    case 0:
      break;
    case 1:
      return call(std::integral_constant<int, 1>());
    case 2:
      return call(std::integral_constant<int, 2>());
    case 3:
      return call(std::integral_constant<int, 3>());
    case 4:
      return call(std::integral_constant<int, 4>());
    case 5:
      return call(std::integral_constant<int, 5>());
    case 6:
      return call(std::integral_constant<int, 6>());
    case 7:
      return call(std::integral_constant<int, 7>());
    default:
      return call(std::integral_constant<int, 8>());
  }
}

}  // namespace cogrsim::bullet
