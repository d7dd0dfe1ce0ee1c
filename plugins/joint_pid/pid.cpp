#include "pid.h"

#include <algorithm>

namespace joint_pid {

double Pid::update(double target, double position, double velocity, double dt) {
  const double error = target - position;
  const double rest = gains_.kp * error - gains_.kd * velocity;
  const double step = gains_.ki * error * dt;
  const double wanted = rest + integral_ + step;
  const bool pushes_out =
      (wanted > gains_.limit && step > 0) || (wanted < -gains_.limit && step < 0);
  if (!pushes_out) integral_ = std::clamp(integral_ + step, -gains_.limit, gains_.limit);
  return std::clamp(rest + integral_, -gains_.limit, gains_.limit);
}

}  // namespace joint_pid
