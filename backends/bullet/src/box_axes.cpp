#include "box_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cogrsim::bullet {

namespace {

// What counts as clearly better, as part of the boxes' smallest half size.
constexpr double kFaceBias = 1e-5;
constexpr double kEdgeBias = 1e-3;
// Edges nearer to parallel than this (sine, squared) have no product worth trying.
constexpr double kParallel = 1e-6;

}  // namespace

bool separating_axis(const btTransform& X_WA, const btVector3& half_a, const btTransform& X_WB,
                     const btVector3& half_b, double threshold, btVector3& normal) {
  const btMatrix3x3& RA = X_WA.getBasis();
  const btMatrix3x3& RB = X_WB.getBasis();
  const btVector3 d = X_WA.getOrigin() - X_WB.getOrigin();
  const btVector3 d_a = d * RA, d_b = d * RB;
  double C[3][3], Q[3][3];  // RA^T RB and its absolute values
  const btMatrix3x3 product = RA.transposeTimes(RB);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      C[i][j] = product[i][j];
      Q[i][j] = std::abs(C[i][j]);
    }
  }
  double face_a = -std::numeric_limits<double>::infinity(), face_b = face_a;
  int axis_a = 0, axis_b = 0;
  for (int k = 0; k < 3; ++k) {
    const double gap_b = std::abs(d_b[k]) - half_b[k] -
                         (Q[0][k] * half_a[0] + Q[1][k] * half_a[1] + Q[2][k] * half_a[2]);
    const double gap_a = std::abs(d_a[k]) - half_a[k] -
                         (Q[k][0] * half_b[0] + Q[k][1] * half_b[1] + Q[k][2] * half_b[2]);
    if (gap_a > threshold || gap_b > threshold) return false;
    if (gap_b > face_b) {
      face_b = gap_b;
      axis_b = k;
    }
    if (gap_a > face_a) {
      face_a = gap_a;
      axis_a = k;
    }
  }
  const double size = std::min(half_a[half_a.minAxis()], half_b[half_b.minAxis()]);
  const bool of_a = face_a > face_b + kFaceBias * size;
  double most = std::max(face_a, face_b) + kEdgeBias * size;
  int edge_a = -1, edge_b = -1;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const double sine2 = 1.0 - C[i][j] * C[i][j];
      if (sine2 < kParallel) continue;
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      // Axis a_i x b_j; in A's axes its components are along i1 and i2 alone, in B's along j1, j2.
      const double reach = half_a[i1] * Q[i2][j] + half_a[i2] * Q[i1][j] + half_b[j1] * Q[i][j2] +
                           half_b[j2] * Q[i][j1];
      const double along = std::abs(d_a[i2] * C[i1][j] - d_a[i1] * C[i2][j]);
      const double gap = (along - reach) / std::sqrt(sine2);
      if (gap > threshold) return false;
      if (gap > most) {
        most = gap;
        edge_a = i;
        edge_b = j;
      }
    }
  }
  if (edge_a >= 0) {
    normal = RA.getColumn(edge_a).cross(RB.getColumn(edge_b)).normalized();
  } else {
    normal = of_a ? RA.getColumn(axis_a) : RB.getColumn(axis_b);
  }
  if (normal.dot(d) < 0.0) normal = -normal;
  return true;
}

}  // namespace cogrsim::bullet
