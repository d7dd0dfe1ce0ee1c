#include "common/interrupt.h"

#include <atomic>
#include <csignal>
#include <cstdio>

#include <unistd.h>

#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::cli {
namespace {

// Shared with the signal handler, which can use only static data.
std::atomic<bool> g_interrupted{false};
std::atomic<int> g_signal{0};
std::atomic<Simulation*> g_watched{nullptr};

constexpr unsigned kPatience = 3;  // [s]

// Signals in a row: the handler of the first, of the alarm, none.
void on_alarm(int) {
  constexpr char kBegin[] = "\nerror: interrupted while something did not return: ";
  constexpr char kUnknown[] = "a scene that loads, a controller or an engine";
  char call[768];
  const std::size_t length = PluginCall::describe(call, sizeof call);
  static_cast<void>(!write(STDERR_FILENO, kBegin, sizeof kBegin - 1));
  static_cast<void>(!(length > 0 ? write(STDERR_FILENO, call, length)
                                 : write(STDERR_FILENO, kUnknown, sizeof kUnknown - 1)));
  static_cast<void>(!write(STDERR_FILENO, "\n", 1));
  const int signal = g_signal.load();
  std::signal(signal, SIG_DFL);
  raise(signal);
}

void on_signal(int signal) {
  g_signal.store(signal);
  g_interrupted.store(true);
  alarm(kPatience);
  if (Simulation* simulation = g_watched.load()) simulation->stop();
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  // Reset: a second Ctrl-C ends the process. Restart: writing output continues undisturbed.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = on_alarm;
  sigaction(SIGALRM, &action, nullptr);
}

bool interrupted() {
  if (!g_interrupted.load()) return false;
  alarm(0);
  return true;
}

tl::unexpected<Error> nothing_written(const std::string& where) {
  return fail("interrupted: nothing was written", where);
}

std::function<bool()> later_interrupt() {
  return [before = interrupted()] { return interrupted() && !before; };
}

void forget_interrupt() { g_interrupted.store(false); }

void end_as_interrupted() {
  if (!interrupted()) return;
  std::fflush(nullptr);
  const int signal = g_signal.load();
  std::signal(signal, SIG_DFL);
  raise(signal);
}

InterruptStops::InterruptStops(Simulation& simulation) {
  g_watched.store(&simulation);
  if (interrupted()) simulation.stop();
}

InterruptStops::~InterruptStops() {
  g_watched.store(nullptr);
  static_cast<void>(interrupted());
}

}  // namespace cogrsim::cli
