// Distribution of friction among the contact points of a pair of bodies, for backends.
#pragma once

#include <cstddef>

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

/// Redistributes the friction of one pair of bodies among its `count` contact points. The resultant
/// force and the resultant moment about the normal stay the same. For rigid bodies the distribution
/// is indeterminate: a solver that treats one point after the other leaves internal forces between
/// the points, up to the friction cone. Of all distributions with the same resultant this function
/// chooses the one with the smallest sum |f_i|^2 / N_i:
///
///     f_i = N_i (F / N + m n x (r_i - c)),  m = M / sum N_i |n x (r_i - c)|^2
///
/// with N_i the normal loads, N their sum, F = sum f_i, c = sum N_i r_i / N, and M the moment of
/// all f_i about c along n. For points in one plane all six components of the resultant wrench stay
/// the same. A resultant force alone never exceeds the friction cone at any point, but a moment
/// may, so the solver must still clamp.
///
/// `loads` (count): normal forces or impulses, >= 0. `points` (count): positions [m]. `friction`
/// (count): input and output, in the unit of the loads, perpendicular to the unit vector `normal`.
/// All vectors are in the same axes. Nothing changes if fewer than two points have a load.
COGRSIM_API void share_friction(std::size_t count, const Vec3& normal, const double* loads,
                                const Vec3* points, Vec3* friction);

}  // namespace cogrsim
