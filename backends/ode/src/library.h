// ODE as a whole: its start, its threads' data, its errors, its random numbers.
#pragma once

#include <ode/ode.h>

#include <stdexcept>

namespace cogrsim::ode {

/// What ODE complains of when it would end the process.
struct EngineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// To be called before anything of ODE on every thread; cheap after the first time. Throws
/// EngineError.
void prepare_thread();

/// dWorldQuickStep with a source of random numbers that belongs to the world: ODE has one for the
/// whole process, from which it sorts the sweeps. Worlds on several threads take turns here.
void quick_step(dWorldID world, double dt, unsigned long& seed);

}  // namespace cogrsim::ode
