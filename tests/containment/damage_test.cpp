// Reports of a simulation when the channels from its controller's process are damaged.
#include <sys/resource.h>
#include <unistd.h>

#include <limits>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

TEST_CASE("an end reported only by the shared memory is not trusted", "[containment]") {
  auto simulation = simulate(flywheel(trouble("scribble")), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  INFO(messages_of(*simulation));
  CHECK_THAT(messages_of(*simulation), Contains("sent inconsistent data"));
  CHECK_THAT(messages_of(*simulation), !Contains("crashed") && !Contains("taken up"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a stopped watchdog is resumed", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  ControllerModel controller = trouble("stop-watchdog-and-crash");
  controller.deadline = std::numeric_limits<double>::infinity();
  auto simulation = simulate(flywheel(controller), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  CHECK_THAT(messages_of(*simulation), Contains("crashed (SIGSEGV) in update"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a process that was lost before is reported with the reason", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  auto simulation = simulate(flywheel(trouble("crash-in-save")), "bullet");
  simulation->run_until(0.05);
  static_cast<void>(simulation->reload_controller("bot"));  // asks for its memory
  simulation->run_until(0.2);
  CHECK_THAT(messages_of(*simulation),
             Contains("has no process any more in update; it crashed (SIGBUS) while its state "
                      "was saved"));
}

TEST_CASE("threads without memory for their stacks report the limit", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  ControllerModel controller = trouble("many-threads");
  controller.memory = 100e6;  // twelve stacks of 8 MB
  auto simulation = simulate(flywheel(controller), "bullet");
  simulation->run_until(0.2);
  CHECK_THAT(messages_of(*simulation),
             Contains("it may take 100 MB of memory, stacks of threads included"));
}

TEST_CASE("a limit beyond all memory has no effect", "[containment]") {
  ControllerModel controller = trouble("nothing");
  controller.memory = 1e36;
  auto simulation = simulate(flywheel(controller), "bullet");
  CHECK(simulation->run_until(0.1) == RunStatus::completed);
  CHECK(messages_of(*simulation).empty());
}

TEST_CASE("running out of file descriptors is reported with a remedy", "[containment]") {
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
  std::string said;
  // Between none and enough available, each operation that needs one fails.
  for (rlim_t most = 3; most < 24; ++most) {
    rlimit few = before;
    few.rlim_cur = most;
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &few) == 0);
    SimulationOptions options;
    options.backend = "bullet";
    auto simulation = Simulation::create(flywheel(trouble("nothing")), options, loader());
    ::setrlimit(RLIMIT_NOFILE, &before);
    if (simulation) break;
    for (const Diagnostic& d : simulation.error()) said += d.code + " " + d.message + "\n";
  }
  INFO(said);
  CHECK_THAT(said, Contains("cannot create a socket: Too many open files") && Contains("ulimit -n"));
  CHECK(descendants(::getpid()).empty());
}
