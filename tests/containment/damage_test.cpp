// What a simulation says when the ways of its controller's process to tell it something are damaged.
#include <sys/resource.h>
#include <unistd.h>

#include <limits>

#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

TEST_CASE("an end that only the shared memory tells of is not believed", "[containment]") {
  auto simulation = simulate(flywheel(trouble("scribble")), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  INFO(messages_of(*simulation));
  CHECK_THAT(messages_of(*simulation), Contains("sent something that does not fit together"));
  CHECK_THAT(messages_of(*simulation), !Contains("crashed") && !Contains("taken up"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a guard that was stopped is woken", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  ControllerModel mind = trouble("stop-guard-and-crash");
  mind.deadline = std::numeric_limits<double>::infinity();
  auto simulation = simulate(flywheel(mind), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  CHECK_THAT(messages_of(*simulation), Contains("crashed (SIGSEGV) in update"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a process that was lost before is missed with the reason", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  auto simulation = simulate(flywheel(trouble("crash-in-save")), "bullet");
  simulation->run_until(0.05);
  simulation->reload_controller("bot");  // asks for its memory
  simulation->run_until(0.2);
  CHECK_THAT(messages_of(*simulation),
             Contains("has no process any more in update; it crashed (SIGBUS) while its memory "
                      "was saved"));
}

TEST_CASE("threads without room for their stacks are told of the bound", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  ControllerModel mind = trouble("many-threads");
  mind.memory = 100e6;  // twelve stacks of 8 MB
  auto simulation = simulate(flywheel(mind), "bullet");
  simulation->run_until(0.2);
  CHECK_THAT(messages_of(*simulation),
             Contains("it may take 100 MB of memory, stacks of threads included"));
}

TEST_CASE("a bound beyond all memory is none", "[containment]") {
  ControllerModel mind = trouble("nothing");
  mind.memory = 1e36;
  auto simulation = simulate(flywheel(mind), "bullet");
  CHECK(simulation->run_until(0.1) == RunStatus::completed);
  CHECK(messages_of(*simulation).empty());
}

TEST_CASE("when files run out the way out is told", "[containment]") {
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
  std::string said;
  // Somewhere between none to be had and enough, each thing that needs one fails.
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
  CHECK_THAT(said, Contains("cannot make a socket: Too many open files") && Contains("ulimit -n"));
  CHECK(descendants(::getpid()).empty());
}
