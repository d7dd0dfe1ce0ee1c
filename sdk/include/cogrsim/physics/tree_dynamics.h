// Dynamics of the trees of joints of a scene, in the speeds of the joints:
//
//   M(q) du/dt + c(q, u) = tau
//
// M is the mass matrix, c the Coriolis, gyroscopic and gravity terms, tau the efforts along the
// speeds. For controllers (computed torque, gravity compensation, operational space) and for
// comparisons with other programs; no engine computes its steps with it.
//
// The speeds are all u of the joints as in WorldState::joint_velocities, then six for each floating
// base: velocity of the body's origin, angular velocity, both in world axes. A floating base is the
// first body of a tree that is not held by the world, a static or a kinematic body; of the effort, its
// six are the force and the torque about its origin. The state gives q and u of the joints, and poses
// and twists of the bases and kinematic bodies; those of the other bodies follow and are not read.
//
// Weights and the inertia of rotors are included. Not included are all other efforts: of springs,
// damping, friction, limits, motors, `<force>` and its kind, couplings, contacts. A joint that closes
// a loop is taken as cut: its rows and columns are zero.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/physics/state.h"

namespace cogrsim {

struct SceneModel;

/// Indices of the floating bases in the order of their speeds.
COGRSIM_API std::vector<int> floating_bases(const SceneModel& model);

/// tau for the rates du/dt of the speeds (joint_speeds + 6 bases), by the recursive Newton-Euler
/// method (Luh, Walker, Paul 1980; Featherstone 2008, section 5.3).
COGRSIM_API Eigen::VectorXd inverse_dynamics(const SceneModel& model, const WorldState& state,
                                             const Eigen::VectorXd& acceleration);

/// M(q), symmetric: column k is inverse_dynamics() at rest without weights for the unit rate k
/// (Walker, Orin 1982, method 1), in time of columns times bodies.
COGRSIM_API Eigen::MatrixXd mass_matrix(const SceneModel& model, const WorldState& state);

}  // namespace cogrsim
