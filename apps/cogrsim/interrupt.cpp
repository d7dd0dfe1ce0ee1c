#include "interrupt.h"

#include <atomic>
#include <csignal>

#include "cogrsim/simulation/simulation.h"

namespace cogrsim::cli {
namespace {

// Shared with the signal handler, which reaches nothing but statics.
std::atomic<bool> g_interrupted{false};
std::atomic<Simulation*> g_watched{nullptr};

void on_signal(int) {
  g_interrupted.store(true);
  if (Simulation* simulation = g_watched.load()) simulation->stop();
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  // Reset: whoever presses Ctrl-C twice means it. Restart: writing output goes on undisturbed.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return g_interrupted.load(); }

InterruptStops::InterruptStops(Simulation& simulation) {
  g_watched.store(&simulation);
  if (interrupted()) simulation.stop();
}

InterruptStops::~InterruptStops() { g_watched.store(nullptr); }

}  // namespace cogrsim::cli
