// ODE as a whole: its start, its threads' data, its errors, and one world of it.
#pragma once

#include <ode/ode.h>

#include <stdexcept>
#include <string>

namespace cogrsim::ode {

/// What ODE complains of when it would end the process.
struct EngineError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// To be called before anything of ODE on every thread; cheap after the first time.
void prepare_thread();

/// An ODE world with its own (single-threaded) job queue, as the default one is shared by all
/// worlds of the process without a lock. Without gravity, damping, sleep and softness of its own.
class Engine {
 public:
  Engine();
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Solves all that is enabled, by Dantzig's method or by sweeps, and moves it. Throws EngineError
  /// and std::bad_alloc.
  void step(double dt) { solve(&dWorldStep, dt); }
  void quick_step(double dt) { solve(&dWorldQuickStep, dt); }

  dWorldID world() const { return world_; }
  dJointGroupID rows() const { return rows_; }

 private:
  void solve(int (*method)(dWorldID, dReal), double dt);

  dWorldID world_ = nullptr;
  dJointGroupID rows_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  bool broken_off_ = false;  ///< an exception left a step
};

}  // namespace cogrsim::ode
