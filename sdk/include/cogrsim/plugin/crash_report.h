// Who was being called when the program crashed.
#pragma once

#include <cstddef>
#include <limits>
#include <string>

#include "cogrsim/core/export.h"

namespace cogrsim {

/// A call into the code of a plugin, for as long as this lives; calls nest, each thread has its own.
/// The texts are kept by address and must outlive it.
class COGRSIM_API PluginCall {
 public:
  /// `kind`: "controller"; `name` as in the scene, "" for none; `of`: the robot, "" for none;
  /// `plugin`: its name, "" where `name` says it; `doing`: "in update"; `time` of the run [s], NaN: there is none.
  PluginCall(const char* kind, const char* name, const char* of, const char* plugin,
             const char* doing, double time = std::numeric_limits<double>::quiet_NaN()) noexcept;
  ~PluginCall();
  PluginCall(const PluginCall&) = delete;
  PluginCall& operator=(const PluginCall&) = delete;

  /// Writes what this thread is calling now, such as "controller 'bot.mind' of 'bot' (plugin 'pid') in
  /// update at 0.25 s", without a zero at its end, and returns its length; 0: nothing is called. May
  /// be called from a signal handler.
  static std::size_t describe(char* text, std::size_t size) noexcept;
  /// The same.
  static std::string described();

 private:
  const char *kind_, *name_, *of_, *plugin_, *doing_;
  double time_;
  PluginCall* outer_;
};

/// From now on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT; an overflow of the stack, too) says
/// on the standard error what was being called, and then takes its course: the process ends by the
/// signal, or in the handler that was there before. For programs, in main(): a library has no
/// business with the signals of others.
COGRSIM_API void report_crashes();

}  // namespace cogrsim
