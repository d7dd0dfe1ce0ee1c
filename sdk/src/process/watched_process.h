// A program in a process of its own, and its watchdog: of an isolated controller, or of a backend.
//
// simulation ── watchdog ── worker ── processes that it starts
//
// The watchdog is the program cogrsim_controller_host, and the worker is its child: a fork of it, or
// a program in another language. The watchdog
// only waits. When the worker ends, it reports how. When the simulation closes its end of the
// socket, or the system closes it after a SIGKILL, the watchdog kills the worker and all processes
// that the worker has started. The system kills the worker when the watchdog ends.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "process/confinement.h"

namespace cogrsim {

/// How a process ended. Its watchdog reports this over a socket to which the process itself has no
/// access.
struct ProcessEnd {
  bool reported = false;        ///< false: the watchdog ended without a report
  int status = 0;               ///< as returned by waitpid()
  std::int64_t most_bytes = 0;  ///< maximum resident memory [byte]

  /// "crashed (SIGSEGV)", "ended its process (exit code 1)", "lost its process".
  std::string text() const;
};

/// A watchdog and its worker, as seen by the simulation.
class WatchedProcess {
 public:
  struct Options {
    /// The worker's own program with its arguments; empty: the worker is a fork of the watchdog.
    std::vector<std::string> command;
    std::string folder;                   ///< in which it runs; empty: that of this process
    std::optional<Confinement> confined;  ///< of a command: what it may reach; none: all
    int output = -1;  ///< descriptor of its standard output and error; -1: those of this process
    const char* what = "each controller";  ///< for errors: what needs the processes
  };
  /// Starts the program, which finds a copy of `channel` as watchdog::kChannel: shared memory, or a
  /// socket that the worker alone has. Errors: the program is missing, or those of the system.
  static Result<std::unique_ptr<WatchedProcess>> start(int channel, Options options);
  ~WatchedProcess();  ///< kills the remaining processes
  WatchedProcess(const WatchedProcess&) = delete;
  WatchedProcess& operator=(const WatchedProcess&) = delete;

  /// Kills the process and all processes that it has started, and waits until they have ended.
  void kill();
  bool alive() const { return watchdog_ > 0; }
  pid_t watchdog() const { return watchdog_; }  ///< -1: it has ended
  /// Whether the watchdog has ended.
  bool gone();
  /// Receives the report about the end; false: there is none.
  bool receive_end();
  /// Valid after receive_end().
  const ProcessEnd& end() const { return end_; }

 private:
  WatchedProcess() = default;

  int link_ = -1;
  pid_t watchdog_ = -1;
  ProcessEnd end_;
};

/// How the user can raise a limit of the system that `problem`, an errno, speaks of; may be empty.
std::string remedy_of(int problem, const std::string& what);

/// Path of the program, which is installed next to the plugins of this library.
std::string controller_host_path();

}  // namespace cogrsim
