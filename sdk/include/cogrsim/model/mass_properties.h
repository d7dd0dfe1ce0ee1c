// Mass, centre of mass and inertia of shapes, and of bodies glued from them.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim {

struct MassProperties {
  double mass = 0.0;            ///< [kg]
  Vec3 com = Vec3::Zero();      ///< [m]
  Mat3 inertia = Mat3::Zero();  ///< about com [kg m^2], in the axes com is given in
};

/// Volume [m^3] of a solid shape; meshes by the divergence theorem. 0 for planes and heightmaps.
COGRSIM_API double shape_volume(const Shape& shape, const std::vector<TriangleMesh>& meshes);

/// A homogeneous solid of `mass` [kg] in the body's frame. Closed forms for the primitives; meshes
/// by Mirtich's surface integrals (Fast and Accurate Computation of Polyhedral Mass Properties,
/// 1996) through tetrahedra. Errors: a plane, heightmap or mesh without positive volume.
COGRSIM_API Result<MassProperties> shape_mass(const Shape& shape,
                                              const std::vector<TriangleMesh>& meshes, double mass);

/// The sum of several parts given in one frame (parallel axis theorem).
COGRSIM_API MassProperties combine(const std::vector<MassProperties>& parts);

/// Errors when mass is not positive or finite, or the inertia is not symmetric, not positive
/// definite, or its principal moments violate the triangle inequality; the message shows the
/// moments.
COGRSIM_API Result<> check_mass_properties(double mass, const Mat3& inertia);

}  // namespace cogrsim
