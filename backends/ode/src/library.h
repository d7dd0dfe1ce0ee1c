// ODE as a whole: its start, its threads' data, its errors, its random numbers.
#pragma once

#include <ode/ode.h>

#include <stdexcept>
#include <string>

namespace cogrsim::ode {

/// What ODE complains of when it would end the process.
struct EngineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// To be called before anything of ODE on every thread; cheap after the first time. Throws
/// EngineError.
void prepare_thread();

/// "0.16.2 (libode.so.8.0.2)": ODE has no function that says its version, so this is that of the
/// headers and the name of the library that was loaded.
const char* library_version();

/// dWorldQuickStep with a source of random numbers that belongs to the world: ODE has one for the
/// whole process, from which it sorts the sweeps. Worlds on several threads take turns here.
void quick_step(dWorldID world, double dt, unsigned long& seed);

}  // namespace cogrsim::ode
