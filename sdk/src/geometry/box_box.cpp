#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/manifold.h"

namespace cogrsim::geometry {
namespace {

// Nearest points of two lines through p and q along the unit directions u and v.
void nearest_on_lines(const Vec3& p, const Vec3& u, const Vec3& q, const Vec3& v, Vec3& on_p,
                      Vec3& on_q) {
  const Vec3 d = q - p;
  const double uv = u.dot(v), ud = u.dot(d), vd = v.dot(d);
  const double det = std::max(1.0 - uv * uv, 1e-12);
  on_p = p + u * ((ud - uv * vd) / det);
  on_q = q + v * ((uv * ud - vd) / det);
}

// Middle of the edge along `axis` that lies farthest towards the world direction d.
Vec3 edge_towards(const PlacedBox& box, int axis, const Vec3& d) {
  Vec3 p = box.X_WS.p;
  for (int k = 0; k < 3; ++k) {
    if (k == axis) continue;
    const Vec3 e = box.X_WS.R.col(k);
    p += (e.dot(d) > 0 ? box.half[k] : -box.half[k]) * e;
  }
  return p;
}

}  // namespace

Separation separate_boxes(const PlacedBox& a, const PlacedBox& b, double margin) {
  // An edge pair must be better than the best face by this much: faces make steadier manifolds.
  constexpr double kRelativeBias = 0.02, kAbsoluteBias = 1e-6;
  const Mat3 C = a.X_WS.R.transpose() * b.X_WS.R;
  const Mat3 Q = C.cwiseAbs();
  const Vec3 d = b.X_WS.p - a.X_WS.p;
  const Vec3 d_a = a.X_WS.R.transpose() * d, d_b = b.X_WS.R.transpose() * d;

  Separation best;
  double most = -kInfinity;
  for (int k = 0; k < 3; ++k) {
    const double gap_a = std::abs(d_a[k]) - a.half[k] - Q.row(k).dot(b.half);
    const double gap_b = std::abs(d_b[k]) - b.half[k] - Q.col(k).dot(a.half);
    if (gap_a > margin || gap_b > margin) return best;
    if (gap_a > most) {
      most = gap_a;
      best.normal = d_a[k] > 0 ? Vec3(a.X_WS.R.col(k)) : Vec3(-a.X_WS.R.col(k));
    }
    // The second box must be clearly better, so that rounding does not swap the reference face.
    if (gap_b > most + kAbsoluteBias) {
      most = gap_b;
      best.normal = d_b[k] > 0 ? Vec3(b.X_WS.R.col(k)) : Vec3(-b.X_WS.R.col(k));
    }
  }
  int edge_a = -1, edge_b = -1;
  double edge_gap = most;
  Vec3 edge_normal = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Vec3 axis = a.X_WS.R.col(i).cross(b.X_WS.R.col(j));
      const double length = axis.norm();
      if (length < 1e-3) continue;
      axis /= length;
      const double along = d.dot(axis);
      double extent = 0.0;
      for (int k = 0; k < 3; ++k)
        extent += a.half[k] * std::abs(a.X_WS.R.col(k).dot(axis)) +
                  b.half[k] * std::abs(b.X_WS.R.col(k).dot(axis));
      const double gap = std::abs(along) - extent;
      if (gap > margin) return best;
      if (gap > edge_gap) {
        edge_gap = gap;
        edge_a = i;
        edge_b = j;
        edge_normal = along > 0 ? axis : Vec3(-axis);
      }
    }
  }
  best.found = true;
  best.gap = most;
  if (edge_a >= 0 && edge_gap > most + kRelativeBias * std::abs(most) + kAbsoluteBias) {
    best.normal = edge_normal;
    best.gap = edge_gap;
    nearest_on_lines(edge_towards(a, edge_a, edge_normal), a.X_WS.R.col(edge_a),
                     edge_towards(b, edge_b, -edge_normal), b.X_WS.R.col(edge_b), best.on_a,
                     best.on_b);
    best.has_points = true;
  }
  return best;
}

}  // namespace cogrsim::geometry
