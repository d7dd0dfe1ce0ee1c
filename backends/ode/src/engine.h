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

  /// After an EngineError out of a step: the job queue is left behind, as ODE would complain again of
  /// what is still in it.
  void abandon() { abandoned_ = true; }

  dWorldID world() const { return world_; }
  dJointGroupID rows() const { return rows_; }

 private:
  dWorldID world_ = nullptr;
  dJointGroupID rows_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  bool abandoned_ = false;
};

}  // namespace cogrsim::ode
