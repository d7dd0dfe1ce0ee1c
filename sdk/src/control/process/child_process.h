// The process of an isolated controller and its watchdog.
//
// simulation ── watchdog ── worker (the controller) ── processes that it starts
//
// The watchdog is the program cogrsim_controller_host, and the worker is its child: a fork of it, or
// for a controller in another language a program of that language. The watchdog
// only waits. When the worker ends, it reports how. When the simulation closes its end of the
// socket, or the system closes it after a SIGKILL, the watchdog kills the worker and all processes
// that the worker has started. The system kills the worker when the watchdog ends.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <string>

#include "control/process/channel.h"

namespace cogrsim {

/// The process of an isolated controller, as seen by the simulation.
class ChildProcess {
 public:
  /// Starts the program. `command`: the worker's own program with its arguments; empty: the worker is
  /// a fork of the watchdog. Errors: the program is missing, or those of the operating system.
  static Result<std::unique_ptr<ChildProcess>> start(std::vector<std::string> command = {});
  ~ChildProcess();  ///< kills the remaining processes
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends one request and waits for its reply, at most `patience`.
  Result<CallChannel::Answer> call(const std::vector<char>& request, std::vector<char>& reply,
                                   std::chrono::duration<double> patience);
  /// How the process ended; valid after Answer::ended.
  const ProcessEnd& end() const { return end_; }
  /// Kills the process and all processes that it has started, and waits until they have ended.
  void kill();
  bool alive() const { return watchdog_ > 0; }

 private:
  ChildProcess() = default;
  bool watchdog_gone();
  bool receive_end();

  CallChannel channel_;
  int link_ = -1;
  pid_t watchdog_ = -1;
  ProcessEnd end_;
};

/// Path of the program, which is installed next to the plugins of this library.
std::string controller_host_path();

}  // namespace cogrsim
