// Between CogRSim's and Simbody's vectors.
#pragma once

#include <algorithm>

#include "placement.h"
#include "simbody_types.h"

namespace cogrsim::dynamics {

inline Mat3 from_simtk(const SimTK::SymMat33& m) {
  Mat3 out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out(r, c) = r >= c ? m(r, c) : m(c, r);
  return out;
}

inline Pose pose_of(const Placement& X) {
  const Mat3& R = X.R;
  const SimTK::Rotation rotation(
      SimTK::Mat33(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
      true);
  return {X.p, from_simtk(rotation)};
}

// Simbody's vector arithmetic goes entry by entry through a call, and makes temporaries on the heap:
// what a step does often is done on the numbers themselves, which lie one after the other.
inline const double* numbers(const SimTK::Vector& v) { return v.size() > 0 ? &v[0] : nullptr; }
inline double* numbers(SimTK::Vector& v) { return v.size() > 0 ? &v[0] : nullptr; }

/// to := from; `to` keeps its memory where it has the size already.
inline void copy(const SimTK::Vector& from, SimTK::Vector& to) {
  if (to.size() != from.size()) to.resize(from.size());
  std::copy_n(numbers(from), from.size(), numbers(to));
}
/// out := a + factor b, all of one size; `out` may be one of them.
inline void add(const SimTK::Vector& a, double factor, const SimTK::Vector& b, SimTK::Vector& out) {
  // Asking a vector of Simbody's for its size is a call.
  const int size = a.size();
  if (out.size() != size) out.resize(size);
  const double* const x = numbers(a);
  const double* const y = numbers(b);
  double* const sum = numbers(out);
  for (int i = 0; i < size; ++i) sum[i] = x[i] + factor * y[i];
}

}  // namespace cogrsim::dynamics
