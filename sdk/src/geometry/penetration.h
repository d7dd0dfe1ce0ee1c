// How deep convex sets are in each other.
#pragma once

#include <functional>

#include "cogrsim/geometry/convex.h"
#include "cogrsim/geometry/overlap.h"
#include "cogrsim/geometry/triangles.h"

namespace cogrsim::geometry {

/// Shortest way of the origin out of a convex set whose point furthest along d is support(d), by an
/// expanding polytope (van den Bergen, "Proximity queries and penetration depth computation on 3D
/// game objects", GDC 2001). Unlike there the polytope need not hold the origin at first: faces
/// are taken by their signed distance, so that no simplex has to be handed over.
///
/// `normal` is the outward one of the set's supporting plane that is nearest to the origin; `depth`
/// the origin's distance to it, 0 or less where the origin is not inside. It is never too small, and
/// too large by at most 1e-4 of itself + 1e-10 of the set's size: exact up to rounding between
/// polytopes. Ends early where it is known to be at most `enough` [m]. Adds to `rounds`.
Penetration origin_depth(const std::function<Vec3(const Vec3&)>& support, double enough,
                         std::size_t& rounds);

/// Of two convex shapes. Depths of at most `enough` [m] may come out as any number up to it. Adds to
/// `rounds` those of the polytope.
Penetration convex_penetration(const Placed& a, const Placed& b, double enough,
                               std::size_t& rounds);

/// How far `a` must be lifted along +z of the frame of the triangle's corners until all of it is
/// above the triangle [m]; `X` is its pose in that frame. At most `enough`: not more than `enough`.
double lift_over(const Placed& a, const Triangle& triangle, double enough);

}  // namespace cogrsim::geometry
