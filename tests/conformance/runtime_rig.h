// Changing a running world as a simulation does, in one line each.
#pragma once

#include <functional>
#include <string>

#include "support.h"

namespace conformance {

/// A copy of the world's scene to add to or to mark as removed.
ModelBuilder next_of(Sim& sim);

/// Takes over what World::add, remove or change was given; any error fails the test case.
void add(Sim& sim, const SceneModelPtr& next);
void remove(Sim& sim, const SceneModelPtr& next);
void change(Sim& sim, const SceneModelPtr& next);

/// Joins two bodies where they are; z of `X_WJ` is the axis. Returns the joint.
int attach(Sim& sim, const std::string& name, JointType type, int parent, int child,
           const Pose& X_WJ);
/// Removes a joint and its motors.
void detach(Sim& sim, int joint);
void set_static(Sim& sim, int body, bool on);
void set_axis(Sim& sim, int joint, const std::function<void(JointAxis&)>& edit, int axis = 0);

/// Relative velocity at the joint that it does not allow [m/s], [rad/s].
double forbidden_speed(Sim& sim, int joint);
/// How far the joint gapes [m], [rad].
double gap(Sim& sim, int joint);

}  // namespace conformance
