// Bodies and joints of a scene as Simbody's. For all backends on its multibody trees.
#pragma once

#include <array>

#include "cogrsim/model/scene_model.h"
#include "simbody_types.h"

namespace cogrsim::dynamics {

/// `mass` [kg] and `inertia` [kg m^2] about the centre of mass: those of the body, or its share where it
/// is cut. A kinematic body has a mass of 1 kg that nothing feels.
SimTK::Body::Rigid rigid_body(const Body& body, double mass, const Mat3& inertia);

/// A joint, or the freedom of a body without one, as a mobilizer.
struct Mobilizer {
  SimTK::MobilizedBody mobod;
  /// q_map[i]: place, among the mobilizer's q, of the model's q_i; u_map likewise.
  std::array<int, 7> q_map{0, 1, 2, 3, 4, 5, 6};
  std::array<int, 6> u_map{0, 1, 2, 3, 4, 5};
};

/// `reversed`: outboard is the joint's parent. `anchor`: pose of the body that the joint is fixed to where
/// `inboard` is the ground in its place; else null.
Mobilizer mobilizer_of(const Joint& joint, bool reversed, SimTK::MobilizedBody inboard,
                       const Pose* anchor, const SimTK::Body::Rigid& rigid);

}  // namespace cogrsim::dynamics
