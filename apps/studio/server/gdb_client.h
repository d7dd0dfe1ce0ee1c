// gdb, driven through its machine interface, as a process of this one.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "mi_record.h"

namespace cogrsim::studio {

class GdbClient {
 public:
  /// Records that answer no command, in order, from the client's own thread. After the last one
  /// `ended` is called, with how gdb ended.
  struct Listener {
    std::function<void(MiRecord)> record;
    std::function<void(std::string)> ended;
  };

  /// Starts `program`. Errors: it is not there, or those of the system.
  static Result<std::unique_ptr<GdbClient>> start(const std::string& program, Listener listener);
  /// Ends gdb, which detaches from what it is attached to; kills it if it does not end.
  ~GdbClient();
  GdbClient(const GdbClient&) = delete;
  GdbClient& operator=(const GdbClient&) = delete;

  /// Sends a command ("-exec-continue"), which has no line end in it, and waits for its result: the
  /// fields of `^done` or `^running`. Errors: gdb's message, gdb has ended, or it does not answer, and
  /// is ended.
  Result<Json> command(const std::string& text,
                       std::chrono::milliseconds patience = std::chrono::seconds(20));
  /// Whether the debugged process stands: what the last `*stopped` or `*running` said.
  bool stopped() const;
  bool wait_until_stopped(std::chrono::milliseconds patience) const;
  bool alive() const;

 private:
  explicit GdbClient(Listener listener) : listener_(std::move(listener)) {}
  void read();
  void take(std::string_view line);
  bool write(std::string_view text);
  std::string reap();

  Listener listener_;
  int socket_ = -1;
  pid_t process_ = -1;
  mutable std::mutex mutex_;
  mutable std::condition_variable news_;
  std::uint64_t last_token_ = 0;
  std::map<std::uint64_t, std::optional<MiRecord>> results_;  ///< that are waited for
  bool stopped_ = false, ended_ = false;
  std::thread reader_;
};

}  // namespace cogrsim::studio
