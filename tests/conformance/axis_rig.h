// One body on one joint in free space, moving along one of the joint's axes with a known inertia.
#pragma once

#include "support.h"

namespace conformance {

/// One freedom of one joint type. `axis` indexes the joint's speeds; of a ball it is 0 and means
/// turning about a direction of the rig's choice.
struct AxisKind {
  std::string name;  ///< "cylindrical 1 (travel)"
  JointType type = JointType::hinge;
  int axis = 0;
  bool angular = true;
};

/// Every axis of every joint type that has any, ball included, free not.
std::vector<AxisKind> axis_kinds();

/// The body's centre of mass stands at the joint's origin, its moments are all equal, and there is
/// no gravity: so the axis moves as inertia * u' = effort, at any angle and speed.
class AxisRig {
 public:
  explicit AxisRig(const AxisKind& kind);

  ModelBuilder builder;
  int body = -1, joint = -1;
  double inertia = 0.0;  ///< along the axis [kg m^2] or [kg]

  /// What acts along the axis, to be set before the world is made.
  JointAxis& axis();
  /// Speed along the axis at the start, given to body and joint alike.
  void start_speed(double u);
  /// Adds a motor and returns its index.
  int motor(MotorMode mode);

  double q(Sim& sim) const;
  double u(Sim& sim) const;
  double effort(Sim& sim) const;

  const AxisKind kind;
};

/// Largest |value - expected| seen.
struct Worst {
  double error = 0.0;
  void see(double value, double expected) {
    const double now = std::abs(value - expected);
    if (!(now <= error)) error = now;  // keeps NaN
  }
};

}  // namespace conformance
