// Rotations as roll, pitch and yaw [rad] about fixed axes, first x, then y, then z:
// R = Rz(yaw) Ry(pitch) Rx(roll).
#pragma once

#include "cogrsim/core/export.h"
#include "cogrsim/core/types.h"

namespace cogrsim {

COGRSIM_API Quat from_rpy(const Vec3& rpy);

/// Of a unit quaternion, with the pitch in [-pi/2, pi/2] and the others in (-pi, pi]. At the ends of the
/// pitch only yaw -+ roll is defined: roll is 0 where the cosine of the pitch is less than `lock`.
COGRSIM_API Vec3 roll_pitch_yaw(const Quat& q, double lock = 1e-9);

}  // namespace cogrsim
