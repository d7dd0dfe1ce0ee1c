// What acts along an axis of a joint, for engines that take it as a row of their solver. For backends;
// header only.
#pragma once

#include <vector>

#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/drive.h"

namespace cogrsim {

/// The motors of an axis, as indices of SceneModel::motors.
inline std::vector<int> motors_of(const SceneModel& model, int joint, int axis) {
  std::vector<int> out;
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const Motor& motor = model.motors[m];
    if (!motor.removed && motor.joint == joint && motor.axis == axis)
      out.push_back(static_cast<int>(m));
  }
  return out;
}

/// A law with gains, taken at the end of a step of `h`: effort = bias + kp (position - q1) + kd (velocity
/// - u1) with q1 = q + h u1 is
///
///     effort = gain (speed - u1),  gain = kd + h kp,  speed = held / gain,
///
/// a speed source that gives way by effort / gain.
struct SoftSource {
  double gain = 0.0;
  double held = 0.0;  ///< the effort at u1 = 0
  double speed() const { return held / gain; }
};
inline SoftSource at_end_of_step(const Drive& law, double h, double q) {
  return {law.kd + h * law.kp, law.bias + law.kp * (law.position - q) + law.kd * law.velocity};
}

}  // namespace cogrsim
