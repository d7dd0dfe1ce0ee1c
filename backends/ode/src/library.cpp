#include "library.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>

namespace cogrsim::ode {

namespace {

void throw_error(int number, const char* format, va_list arguments) {
  char text[400];
  std::vsnprintf(text, sizeof text, format, arguments);
  throw std::runtime_error("error " + std::to_string(number) + ": " + text);
}

// What ODE would print and then continue after: of an LCP that is singular, for one.
void ignore_message(int, const char*, va_list) {}

// Without the size, which ODE does not promise to be that of the request.
void release(void* memory, dsizeint) { ::operator delete(memory); }

void* reallocate(void* old, dsizeint old_size, dsizeint size) {
  void* fresh = ::operator new(size);
  if (old != nullptr) std::memcpy(fresh, old, std::min(old_size, size));
  ::operator delete(old);
  return fresh;
}

// ODE holds caches of its mesh collision per thread which it is to drop when a thread ends.
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
  if (!library.ready) throw std::runtime_error("it cannot be initialised");
  thread_local const ThreadData data;
  if (!data.ready) throw std::runtime_error("it has no memory for another thread");
}

void quick_step(dWorldID world, double dt, unsigned long& seed) {
  static std::mutex chance;
  const std::lock_guard<std::mutex> lock(chance);
  dRandSetSeed(seed);
  dWorldQuickStep(world, dt);
  seed = dRandGetSeed();
}

}  // namespace cogrsim::ode
