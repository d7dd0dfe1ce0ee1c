// Between Eigen and ODE.
#pragma once

#include <ode/ode.h>

#include "cogrsim/core/types.h"

static_assert(sizeof(dReal) == sizeof(double), "ODE must be built for double precision");

namespace cogrsim::ode {

inline Vec3 to_vec(const dReal* v) { return {v[0], v[1], v[2]}; }
inline Quat to_quat(const dReal* q) { return {q[0], q[1], q[2], q[3]}; }

}  // namespace cogrsim::ode
