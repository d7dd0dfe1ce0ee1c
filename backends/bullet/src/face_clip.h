// Contact points between two faces, a face and a round side, or two round sides.
#pragma once

#include "contact_patch.h"
#include "support_feature.h"

namespace cogrsim::bullet {

/// Adds the points that come within `threshold` [m] where `a` and `b` lie over each other along
/// `normal` (unit, from B to A): the corners of what their outlines have in common, with the
/// distance along the normal at each. Two round sides touch at the ends of the stretch they run
/// beside each other, each with the normal between the axes there. Nothing is added for features of
/// kind none, nor where a face leans so far from the normal that it has no height along it.
void clip_features(const SupportFeature& a, const SupportFeature& b, const btVector3& normal,
                   double threshold, ContactPatch& patch);

}  // namespace cogrsim::bullet
