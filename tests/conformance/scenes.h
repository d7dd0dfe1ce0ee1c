// Scenes that several themes run.
#pragma once

#include "support.h"

namespace conformance {

/// Two-wheel robot standing on a plane: a box, two cylinders on hinges with velocity motors (0:
/// left, 1: right), a ball without friction in front. Heads along x of `X_WR`, whose origin lies
/// on the floor between the wheels.
struct TwoWheeler {
  int chassis = -1, left = -1, right = -1;  ///< bodies
  int left_axle = -1, right_axle = -1;      ///< joints; positive speed drives forwards
  double radius = 0.05, track = 0.2;        ///< [m]
};
TwoWheeler add_two_wheeler(ModelBuilder& builder, const std::string& name, const Pose& X_WR);

/// A floor with a bit of everything: falling and stacked bodies, a pendulum, a driven hinge with
/// damping and friction, a robot, a slider that runs into its limit.
struct Playground {
  ModelBuilder builder;
  std::vector<Drive> drives;
};
Playground playground();

/// Three bars on hinges that float, spanning 1.5 m along x.
struct Chain {
  std::vector<int> bars, hinges;
};
Chain add_chain(ModelBuilder& builder, const Pose& X_WC);

}  // namespace conformance
