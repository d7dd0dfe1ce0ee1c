#include "engine.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>

namespace cogrsim::ode {

namespace {

void throw_error(int number, const char* format, va_list arguments) {
  char text[400];
  std::vsnprintf(text, sizeof text, format, arguments);
  throw EngineError("ODE error " + std::to_string(number) + ": " + text);
}

// Without the size, which ODE does not promise to be that of the request.
void release(void* memory, dsizeint) { ::operator delete(memory); }

void* reallocate(void* old, dsizeint old_size, dsizeint size) {
  void* fresh = ::operator new(size);
  if (old != nullptr) std::memcpy(fresh, old, std::min(old_size, size));
  ::operator delete(old);
  return fresh;
}

// The LCP solver reports singular systems so, and goes on with what it has; whether the result is
// any good is seen by the step itself.
void ignore_message(int, const char*, va_list) {}

// ODE keeps caches of its mesh collision per thread and wants to be told when a thread ends.
struct ThreadData {
  ThreadData() { ready = dAllocateODEDataForThread(dAllocateMaskAll) != 0; }
  ~ThreadData() {
    if (ready) dCleanupODEAllDataForThread();
  }
  bool ready = false;
};

// Of the process, until this library is unloaded: that waits for the data of all threads.
struct Library {
  Library() {
    // ODE itself uses what malloc gives without a look at it: these throw.
    dSetAllocHandler(static_cast<void* (*)(dsizeint)>(::operator new));
    dSetReallocHandler(&reallocate);
    dSetFreeHandler(&release);
    ready = dInitODE2(dInitFlagManualThreadCleanup) != 0;
    dSetErrorHandler(&throw_error);
    dSetDebugHandler(&throw_error);
    dSetMessageHandler(&ignore_message);
  }
  ~Library() {
    if (ready) dCloseODE();
  }
  bool ready = false;
};

}  // namespace

void prepare_thread() {
  static const Library library;
  if (!library.ready) throw EngineError("ODE cannot be initialised");
  thread_local const ThreadData data;
  if (!data.ready) throw EngineError("ODE has no memory for another thread");
}

Engine::Engine() {
  prepare_thread();
  world_ = dWorldCreate();
  rows_ = dJointGroupCreate(0);
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_),
                                       threading_);
  dWorldSetGravity(world_, 0, 0, 0);
  dWorldSetAutoDisableFlag(world_, 0);
  dWorldSetLinearDamping(world_, 0);
  dWorldSetAngularDamping(world_, 0);
  dWorldSetERP(world_, 1.0);  // only point rows use it, see rows.cpp
  dWorldSetCFM(world_, 0.0);  // rows bring their own
  dWorldSetContactSurfaceLayer(world_, 0);
}

Engine::~Engine() {
  dJointGroupDestroy(rows_);
  dWorldSetStepThreadingImplementation(world_, nullptr, nullptr);
  dWorldDestroy(world_);
  // With jobs left in it, ODE would complain of them, and end the program.
  if (!broken_off_) dThreadingFreeImplementation(threading_);
}

void Engine::solve(int (*method)(dWorldID, dReal), double dt) {
  try {
    method(world_, dt);
  } catch (...) {
    broken_off_ = true;
    throw;
  }
}

}  // namespace cogrsim::ode
