// Ctrl-C ends a run cleanly; a second one ends the process at once.
#pragma once

#include <functional>
#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim {
class Simulation;
}

namespace cogrsim::cli {

/// From now on SIGINT and SIGTERM are noted, and stop the watched simulation; after the first the
/// signals have their usual effect again. A process that does not call interrupted() within 3 s
/// after it, as while a scene loads or a controller does not return, is ended.
void catch_interrupts();
/// Asked by long work, which then ends and writes its results so far.
bool interrupted();
/// The error of interrupted work that has written nothing. `where`: the file it was for.
tl::unexpected<Error> nothing_written(const std::string& where = {});
/// Says whether an interrupt came after this call, as interrupted() does of all.
std::function<bool()> later_interrupt();
/// For commands that an interrupt ends as usual: they exit with their own status.
void forget_interrupt();
/// Ends the process by the signal that interrupted it, so that shell loops end; returns if there
/// was none.
void end_as_interrupted();

/// While it lives, an interrupt stops `simulation`. One at a time.
class InterruptStops {
 public:
  explicit InterruptStops(Simulation& simulation);
  ~InterruptStops();
  InterruptStops(const InterruptStops&) = delete;
  InterruptStops& operator=(const InterruptStops&) = delete;
};

}  // namespace cogrsim::cli
