// Solids that are not convex, as several that are.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim::geometry {

struct ConvexPartsOptions {
  int most = 8;             ///< parts, 1 to 64
  double tolerance = 0.01;  ///< stop where the parts cover this much outside the solid [of its hull]
  int cells = 48;           ///< along the longest side, 8 to 128: what is smaller is not seen
  /// Steps of some nanoseconds after which no part is cut again. The parts do not depend on the
  /// machine.
  std::size_t steps = std::numeric_limits<std::size_t>::max();
};

struct ConvexParts {
  std::vector<TriangleMesh> hulls;  ///< none: the mesh has no volume
  /// What the hull of the whole mesh, and these parts, cover outside the solid, by counting cells
  /// [volume of that hull].
  double excess_of_hull = 0.0, excess = 0.0;
  std::size_t steps = 0;   ///< taken
  bool cut_short = false;  ///< more steps would have found better parts
};

/// Convex parts that together contain the surface of `mesh`; they may overlap. A cavity without a way
/// out is part of the solid; a mesh with a hole has none. The same mesh has the same parts always.
/// Some 0.1 to 5 s; `steps` bounds it. Not for hostile numbers: coordinates must be finite.
COGRSIM_API ConvexParts convex_parts(const TriangleMesh& mesh,
                                     const ConvexPartsOptions& options = {});

}  // namespace cogrsim::geometry
