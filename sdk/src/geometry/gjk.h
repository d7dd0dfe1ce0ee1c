// Nearest points of convex sets by the algorithm of Gilbert, Johnson and Keerthi, "A fast procedure
// for computing the distance between complex objects in three-dimensional space", IEEE Journal of
// Robotics and Automation 4 (1988), with the simplex reduced by projection on its faces (Ericson,
// Real-Time Collision Detection, 5.1) instead of their recursion, which loses digits where points
// nearly coincide.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "cogrsim/core/types.h"

namespace cogrsim::geometry {

/// Points of which the origin's nearest in their hull is a combination of all.
struct Simplex {
  std::array<Vec3, 4> points;
  std::size_t count = 0;
};

/// Of the hull of `simplex`, the point nearest to the origin; leaves the points it lies between.
Vec3 reduce(Simplex& simplex);

/// The point nearest to the origin of a convex set whose point furthest along d is support(d); 0
/// where the origin is inside. `start`: any point of the set. Its distance is never too small, and
/// too large by at most 1e-10 m + 1e-12 of itself, unless 200 rounds do not reach that (seen with no
/// shape of ours).
template <class Support>
Vec3 nearest_to_origin(const Support& support, const Vec3& start) {
  constexpr int kMostRounds = 200;
  Simplex simplex;
  simplex.points[0] = start;
  simplex.count = 1;
  Vec3 v = start;
  double distance = v.norm();
  for (int round = 0; round < kMostRounds; ++round) {
    if (distance < 1e-12) return Vec3::Zero();
    const Vec3 w = support(Vec3(-v));
    // All of the set lies beyond the plane through w across v.
    if (distance - v.dot(w) / distance <= 1e-10 + 1e-12 * distance) return v;
    for (std::size_t i = 0; i < simplex.count; ++i)
      if (simplex.points[i] == w) return v;  // rounding: there is nothing nearer
    simplex.points[simplex.count++] = w;
    const Vec3 next = reduce(simplex);
    if (simplex.count == 4) return Vec3::Zero();
    const double nearer = next.norm();
    if (nearer >= distance) return v;  // rounding again
    v = next;
    distance = nearer;
  }
  return v;
}

}  // namespace cogrsim::geometry
