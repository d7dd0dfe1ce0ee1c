// Ctrl-C ends a run cleanly; a second one ends the process at once.
#pragma once

namespace cogrsim {
class Simulation;
}

namespace cogrsim::cli {

/// From now on SIGINT and SIGTERM are noted, and stop the watched simulation; after the first the
/// signals have their usual effect again.
void catch_interrupts();
bool interrupted();

/// While it lives, an interrupt stops `simulation`. One at a time.
class InterruptStops {
 public:
  explicit InterruptStops(Simulation& simulation);
  ~InterruptStops();
  InterruptStops(const InterruptStops&) = delete;
  InterruptStops& operator=(const InterruptStops&) = delete;
};

}  // namespace cogrsim::cli
