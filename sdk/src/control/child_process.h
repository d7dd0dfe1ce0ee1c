// The process that a controller lives in, and its guard.
//
// simulation ── guard ── worker (the controller) ── whatever that starts
//
// The guard is the program cogrsim_controller_host, the worker its child. The guard does nothing but
// wait: when the worker ends it says how, and when the simulation's end of a socket is closed, by
// the simulation or by the system after a SIGKILL, it kills the worker and all that this has started.
// The worker itself is killed by the system when the guard goes.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <string>

#include "control/channel.h"

namespace cogrsim {

class ChildProcess {
 public:
  /// Starts the program. Errors: it is not where it belongs, or the system's.
  static Result<std::unique_ptr<ChildProcess>> start();
  ~ChildProcess();  ///< kills what is still there
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// One request and its reply.
  Result<CallChannel::Answer> call(const std::vector<char>& request, std::vector<char>& reply,
                                   std::chrono::duration<double> patience);
  /// After Answer::ended: how.
  const ProcessEnd& end() const { return end_; }
  /// Kills it and all it has started, and waits until they are gone.
  void kill();
  bool alive() const { return guard_ > 0; }

 private:
  ChildProcess() = default;
  bool guard_gone();
  bool hear_end();

  CallChannel channel_;
  int link_ = -1;
  pid_t guard_ = -1;
  ProcessEnd end_;
};

/// The worker's part of the program: serves requests until it is told to end. Returns the exit code.
int serve_controller(CallChannel& channel);

/// File of the program: beside the plugins of this library.
std::string controller_host_path();

}  // namespace cogrsim
