// Who is being called: for the last words of a crash, and for whoever waits.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <limits>
#include <mutex>
#include <optional>
#include <string>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// A call into the code of a plugin, for as long as this lives; calls nest, each thread has its own.
/// The texts are kept by address and must outlive it.
class COGRSIM_API PluginCall {
 public:
  /// `kind`: "controller"; `name` as in the scene, "" for none; `of`: the robot, "" for none;
  /// `plugin`: its name, "" where `name` says it; `doing`: "in update"; `time` of the run [s], NaN: there is none.
  /// `patience`: for a call into a process of its own, after how long that process is killed [s],
  /// infinite: never; NaN: a call into this process.
  PluginCall(const char* kind, const char* name, const char* of, const char* plugin,
             const char* doing, double time = std::numeric_limits<double>::quiet_NaN(),
             double patience = std::numeric_limits<double>::quiet_NaN()) noexcept;
  ~PluginCall();
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

  /// Writes what this thread is calling now in this process, such as "controller 'bot.mind' of 'bot' (plugin 'pid') in
  /// update at 0.25 s", without a zero at its end, and returns its length; 0: nothing is called. May
  /// be called from a signal handler.
  static std::size_t describe(char* text, std::size_t size) noexcept;
  /// The same.
  static std::string described();
  /// Whether PluginWatch::give_up() was called for the call that this thread makes now.
  static bool given_up() noexcept;

 private:
  friend class PluginWatch;
  const char *kind_, *name_, *of_, *plugin_, *doing_;
  double time_, patience_;
  PluginCall* outer_;
};

/// Shows other threads what one thread is calling: who does not return, and since when. Outlives that
/// thread.
class COGRSIM_API PluginWatch {
 public:
  /// As given to PluginCall.
  struct Call {
    std::string kind, name, of, plugin, doing;
    double time = 0.0;      ///< of the run [s]; NaN: there is none
    double lasts = 0.0;     ///< so far, by the clock on the wall [s]
    bool apart = false;     ///< into a process of its own
    double patience = 0.0;  ///< if apart: that process is killed after so long [s]; may be infinite
  };

  PluginWatch() = default;
  PluginWatch(const PluginWatch&) = delete;
  PluginWatch& operator=(const PluginWatch&) = delete;

  /// From now on it is the calling thread that is watched; not while that calls a plugin.
  void watch_this_thread();
  /// The call that is under way, of nested ones the outermost; empty: none. From any thread.
  std::optional<Call> call() const;
  /// Does not wait any longer for the present call into a process of its own: that process is killed
  /// within 0.2 s, as if its patience were over. False: there is no such call. From any thread.
  bool give_up();

 private:
  friend class PluginCall;
  void begin(const PluginCall& call);
  void end();

  mutable std::mutex mutex_;
  const PluginCall* call_ = nullptr;
  std::chrono::steady_clock::time_point since_{};
  std::atomic<bool> given_up_{false};
};

/// From now on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT; an overflow of the stack, too) says
/// on the standard error what was being called, and then takes its course: the process ends by the
/// signal, or in the handler that was there before. For programs, in main(): a library has no
/// business with the signals of others.
COGRSIM_API void report_crashes();

}  // namespace cogrsim
