// A four-bar linkage in the x-z plane, and the positions of its parts.
#pragma once

#include "support.h"

namespace conformance {

struct FourBar {
  ModelBuilder builder;
  int crank = -1, coupler = -1, rocker = -1;                   ///< bodies
  int drive = -1, crank_pin = -1, loop = -1, rocker_pin = -1;  ///< joints
  double crank_angle = 0.0, rocker_angle = 0.0;  ///< at the start, from x towards z [rad]
};

/// Where crank and coupler meet for the crank's angle [rad], and coupler and rocker.
Vec3 point_b(double crank_angle);
Vec3 point_c(double crank_angle);
/// Angle of the rocker [rad] for that of the crank.
double rocker_for(double crank_angle);

/// Bars of 1 kg/m, the crank at 120 degrees, standing. `closing` is the joint between coupler and
/// rocker: any type that lets them turn in the plane. `motor`: motor 0 turns the crank.
FourBar four_bar(bool motor, JointType closing = JointType::hinge);

/// A bar of 1 kg/m that runs from `from` to `to` along its own x.
int add_bar(ModelBuilder& builder, const std::string& name, const Vec3& from, const Vec3& to);

/// Distance [m] by which the joint gapes.
double gap_of(Sim& sim, int joint);

/// Largest gap [m], rocker and crank angle error [rad] with the crank driven at one turn a second
/// from standing.
struct Driven {
  double gap = 0.0, rocker_error = 0.0, crank_error = 0.0;
};
Driven run_driven(double seconds, JointType closing = JointType::hinge);

}  // namespace conformance
