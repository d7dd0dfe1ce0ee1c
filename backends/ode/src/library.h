// ODE as a whole: its start, its threads' data, its errors, its random numbers.
#pragma once

#include <ode/ode.h>

#include "cogrsim/core/types.h"

static_assert(sizeof(dReal) == sizeof(double), "ODE must be built for double precision");

namespace cogrsim::ode {

inline Vec3 to_vec(const dReal* v) { return {v[0], v[1], v[2]}; }
inline Quat to_quat(const dReal* q) { return {q[0], q[1], q[2], q[3]}; }
inline Mat3 to_mat(const dReal* rows_of_four) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows_of_four).leftCols<3>();
}

/// To be called before anything of ODE on every thread; cheap after the first time. What ODE complains
/// of when it would end the process is thrown from then on, as std::runtime_error.
void prepare_thread();

/// dWorldQuickStep with a source of random numbers that belongs to the world: ODE has one for the
/// whole process, from which it sorts the sweeps. Worlds on several threads take turns here.
void quick_step(dWorldID world, double dt, unsigned long& seed);

}  // namespace cogrsim::ode
