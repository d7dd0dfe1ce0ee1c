// Mass, centre of mass and inertia of shapes and of bodies composed of several shapes.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/model/shapes.h"

namespace cogrsim {

/// Mass properties of a rigid body.
struct MassProperties {
  double mass = 0.0;            ///< [kg]
  Vec3 com = Vec3::Zero();      ///< centre of mass [m]
  Mat3 inertia = Mat3::Zero();  ///< about the centre of mass [kg m^2], in the same axes as `com`
};

/// Volume [m^3] of a solid shape, for meshes by the divergence theorem; 0 for planes and
/// heightmaps.
COGRSIM_API double shape_volume(const Shape& shape, const std::vector<MeshPtr>& meshes);

/// Mass properties of a homogeneous solid shape of `mass` [kg], in the body frame. Primitives use
/// closed forms; meshes use a sum over tetrahedra (compare Mirtich, Fast and Accurate Computation
/// of Polyhedral Mass Properties, 1996). Errors: the shape is a plane, a heightmap, or a mesh
/// without positive volume.
COGRSIM_API Result<MassProperties> shape_mass(const Shape& shape,
                                              const std::vector<MeshPtr>& meshes, double mass);

/// Mass properties of several rigidly connected parts that are given in one frame (parallel axis
/// theorem).
COGRSIM_API MassProperties combine(const std::vector<MassProperties>& parts);

/// Checks a mass [kg] and an inertia about the centre of mass [kg m^2]. Errors: the mass is not
/// positive and finite, the inertia is not symmetric or not positive definite, or its principal
/// moments violate the triangle inequality; the message states the principal moments.
COGRSIM_API Result<> check_mass_properties(double mass, const Mat3& inertia);

}  // namespace cogrsim
