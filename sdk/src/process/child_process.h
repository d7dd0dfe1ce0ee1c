// The process of an isolated controller: requests and replies through shared memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "process/channel.h"
#include "process/watched_process.h"

namespace cogrsim {

/// The process of an isolated controller, as seen by the simulation.
class ChildProcess {
 public:
  /// Starts the program. `command`: the worker's own program with its arguments; empty: the worker is
  /// a fork of the watchdog. Errors: the program is missing, or those of the operating system.
  static Result<std::unique_ptr<ChildProcess>> start(std::vector<std::string> command = {});
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends one request and waits for its reply, at most `patience`. While a debugger is attached to
  /// `worker`, the id of the process that runs the controller, there is no limit; 0: not known yet.
  Result<CallChannel::Answer> call(const std::vector<char>& request, std::vector<char>& reply,
                                   std::chrono::duration<double> patience, std::int64_t worker);
  /// Whether a process is the worker, or one that it has started; nullopt: it has ended.
  std::optional<bool> has(std::int64_t process) const;
  /// How the process ended; valid after Answer::ended.
  const ProcessEnd& end() const { return process_->end(); }
  /// Kills the process and all processes that it has started, and waits until they have ended.
  void kill() { process_->kill(); }
  bool alive() const { return process_->alive(); }

 private:
  ChildProcess() = default;

  CallChannel channel_;
  std::unique_ptr<WatchedProcess> process_;
};

}  // namespace cogrsim
