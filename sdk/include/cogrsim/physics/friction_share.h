// For backends: which contact point bears how much of a pair's friction.
#pragma once

#include <cstddef>

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

/// Shares the friction of one pair of bodies anew among its `count` contact points, resultant force
/// and moment about the normal kept. Rigid bodies do not determine the shares: a solver that goes
/// from point to point leaves forces that only press the points against each other, up to the cone.
/// Of all shares with that resultant this takes the smallest, sum |f_i|^2 / N_i being its measure:
///
///     f_i = N_i (F / N + m n x (r_i - c)),  m = M / sum N_i |n x (r_i - c)|^2
///
/// with N_i the loads, N their sum, F = sum f_i, c = sum N_i r_i / N, and M the moment of all f_i
/// about c along n. Points in one plane keep all six components of the wrench. A resultant force
/// alone never exceeds the cone at any point; a moment may, and a solver must still clamp.
///
/// `loads` (count): normal forces or impulses, >= 0; `points` (count): [m]; `friction` (count): in
/// and out, in the unit of the loads, perpendicular to `normal` (unit). Nothing is changed for
/// fewer than two loaded points. All vectors in the same axes.
COGRSIM_API void share_friction(std::size_t count, const Vec3& normal, const double* loads,
                                const Vec3* points, Vec3* friction);

}  // namespace cogrsim
