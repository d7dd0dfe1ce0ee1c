// What joints transmit, from the change of momentum over a step.
#pragma once

#include <vector>

#include "stepper.h"

namespace cogrsim::dynamics {

/// Everything that is known of a step after it.
struct StepRecord {
  double dt = 0.0;
  const Values* start_q = nullptr;
  const Values* start_u = nullptr;
  const std::vector<ContactRecord>* contacts = nullptr;
  const std::vector<Collider>* colliders = nullptr;
  const std::vector<double>* joint_efforts = nullptr;  ///< mean, flat speeds
};

/// Mean force and torque, about M's origin, that each joint's parent exerts on its child. Newton
/// and Euler over the step: what the bodies beyond a joint gained in momentum, less the impulses of
/// gravity and contact, came through the joint. Where a loop was cut, the wrench in the weld is the
/// smallest one with which every joint in the loop has the effort it is known to have.
void calc_joint_reactions(Mechanism& mechanism, const StepRecord& record, std::vector<Wrench>& out);

}  // namespace cogrsim::dynamics
