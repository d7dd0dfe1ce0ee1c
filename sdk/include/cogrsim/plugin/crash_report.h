// Tracking of calls into plugins, for crash reports and for supervising calls that do not return.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <string>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// Marks a call into the code of a plugin for the lifetime of the object. Calls can be nested, and
/// each thread has its own calls. The texts are stored as pointers and must outlive the object.
class COGRSIM_API PluginCall {
 public:
  /// `kind`: the kind of plugin, "controller". `name`: the name in the scene, "" if there is none.
  /// `of`: the robot, "" if there is none. `plugin`: the name of the plugin, "" if it is `name`.
  /// `doing`: the call, "in update". `time`: simulated time [s], NaN if there is none. `patience`:
  /// for a call into another process the time after which that process is killed [s], infinite:
  /// never; NaN: a call in this process.
  PluginCall(const char* kind, const char* name, const char* of, const char* plugin,
             const char* doing, double time = std::numeric_limits<double>::quiet_NaN(),
             double patience = std::numeric_limits<double>::quiet_NaN()) noexcept;
  ~PluginCall();
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

  /// Writes a description of the current call of this thread in this process to `text` and returns
  /// its length, for example "controller 'bot.driver' of 'bot' (plugin 'pid') in update at 0.25 s".
  /// The text is not zero-terminated; the length is 0 if there is no call. Safe in signal handlers.
  static std::size_t describe(char* text, std::size_t size) noexcept;
  /// The description as a string.
  static std::string described();
  /// Whether PluginWatch::give_up() was called for the current call of this thread.
  static bool given_up() noexcept;

 private:
  friend class PluginWatch;
  const char *kind_, *name_, *of_, *plugin_, *doing_;
  double time_, patience_;
  PluginCall* outer_;
};

/// Makes the current call of one thread visible to other threads, so that they can detect a call
/// that does not return. Must outlive that thread.
class COGRSIM_API PluginWatch {
 public:
  /// A call, with the arguments of PluginCall.
  struct Call {
    std::string kind, name, of, plugin, doing;
    double time = 0.0;            ///< simulated time [s]; NaN: there is none
    double lasts = 0.0;           ///< wall-clock duration so far [s]
    bool out_of_process = false;  ///< a call into another process
    double patience = 0.0;  ///< time after which another process is killed [s]; may be infinite
  };

  PluginWatch() = default;
  PluginWatch(const PluginWatch&) = delete;
  PluginWatch& operator=(const PluginWatch&) = delete;

  /// Selects the calling thread as the observed one. Must not be called during a call of a plugin.
  void watch_this_thread();
  /// The current call; of nested calls the outermost; nullopt: none. Thread-safe.
  std::optional<Call> call() const;
  /// Calls `look` with the current call, if there is one, which does not return before `look` has:
  /// until then the data of the observed thread may be read that the called plugin does not change.
  /// Returns false if there is no call. Thread-safe.
  bool during(const std::function<void(const Call&)>& look) const;
  /// Cancels the current call into another process: that process is killed within 0.2 s, as at the
  /// end of its patience. Returns false if there is no such call. Thread-safe.
  bool give_up();

 private:
  friend class PluginCall;
  Call described() const;
  void begin(const PluginCall& call);
  void end();

  mutable std::mutex mutex_;
  const PluginCall* call_ = nullptr;
  std::chrono::steady_clock::time_point since_{};
  std::atomic<bool> given_up_{false};
};

/// Installs a handler that reports the current plugin call on standard error if the program crashes
/// (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, including stack overflow). The process then ends by
/// the signal or in the previous handler. Only programs should call it, in main(); a library should
/// not change signal handlers.
COGRSIM_API void report_crashes();

}  // namespace cogrsim
