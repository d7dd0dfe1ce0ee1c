// Whatever a controller does in its own process, the simulation reports it and continues or ends as
// configured; nothing is left of the process.
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include "../support/engines.h"
#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;

namespace {

struct Case {
  const char* what;
  const char* said;
};

std::size_t open_files() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    count += entry.path().empty() ? 0 : 1;
  }
  return count;
}

/// True as soon as `condition` holds, within 10 s: the machine may be busy.
template <class Condition>
bool soon(Condition&& condition) {
  const auto last = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < last) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

}  // namespace

TEST_CASE("the end of a controller's process is reported and does not end the run",
          "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  const auto c = GENERATE(values<Case>({{"segv", "crashed (SIGSEGV) in update"},
                                        {"overflow", "crashed (SIGSEGV) in update"},
                                        {"abort", "crashed (SIGABRT) in update"},
                                        {"throw-in-thread", "crashed (SIGABRT) in update"},
                                        {"kill", "crashed (SIGKILL) in update"},
                                        {"exit", "ended its process (exit code 3) in update"},
                                        {"exit-quietly", "ended its process (exit code 0)"}}));
  const std::string backend = GENERATE(engines());
  const auto policy = GENERATE(FaultPolicy::stop_controller, FaultPolicy::end_run);
  ControllerModel controller = trouble(c.what);
  controller.on_fault = policy;
  auto simulation = simulate(flywheel(controller), backend);
  const RunStatus end = simulation->run_until(0.2);
  INFO(messages_of(*simulation));
  CHECK_THAT(messages_of(*simulation),
             Contains("controller 'trouble' of 'bot': " + std::string(c.said)));
  check_fault(*simulation, end, policy, 0.03);
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("one that does not come back is killed at its deadline", "[containment]") {
  const std::string what =
      GENERATE("hang", "spin", "stop", "traced-by-watchdog", "traced-by-child");
  ControllerModel controller = trouble(what);
  controller.deadline = 0.3;
  auto simulation = simulate(flywheel(controller), "bullet");
  const auto begin = std::chrono::steady_clock::now();
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  CHECK(std::chrono::steady_clock::now() - begin >= std::chrono::milliseconds(300));
  INFO(messages_of(*simulation));
  CHECK_THAT(messages_of(*simulation),
             Contains("hung in update") && Contains("within 0.3 s") && Contains("was killed"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("memory beyond the limit is refused", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  const std::string what = GENERATE("memory", "malloc");
  ControllerModel controller = trouble(what);
  controller.memory = 100e6;
  auto simulation = simulate(flywheel(controller), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  INFO(messages_of(*simulation));
  CHECK_THAT(messages_of(*simulation), Contains("it may take 100 MB of memory"));
  CHECK_THAT(messages_of(*simulation),
             Contains(what == "memory" ? "threw in update: std::bad_alloc" : "crashed (SIGSEGV)"));
}

TEST_CASE("faults that need no process are reported as without one", "[containment]") {
  const std::string what = GENERATE("throw", "nan", "nothing", "chatter");
  std::string messages[2];
  for (const bool own : {false, true}) {
    ControllerModel controller = trouble(what);
    controller.isolation = own ? Isolation::process : Isolation::none;
    auto simulation = simulate(flywheel(controller), "bullet");
    simulation->run_until(0.1);
    messages[own] =
        messages_of(*simulation) + std::to_string(state_hash(simulation->frame()->state));
  }
  CHECK(messages[0] == messages[1]);
  CHECK(messages[0].empty() == false);
}

TEST_CASE("mistakes in configure are errors of the load", "[containment]") {
  CHECK_THAT(refusal(flywheel(trouble("mistake"))),
             Contains("CG0907") && Contains("there is no motor 'lfet', did you mean 'left'?"));
  CHECK_THAT(refusal(flywheel(trouble("throw-in-configure"))),
             Contains("CG0908 ") && Contains("threw while being configured: no calibration file"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a crash in configure is an error of the load", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  CHECK_THAT(refusal(flywheel(trouble("crash-in-configure"))),
             Contains("crashed (SIGSEGV) while being configured"));
  CHECK(descendants(::getpid()).empty());
}

TEST_CASE("a controller may have threads and print", "[containment]") {
  const std::string what = GENERATE("thread", "print", "fork-and-return");
  auto simulation = simulate(flywheel(trouble(what)), "bullet");
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  CHECK(messages_of(*simulation).empty());
  CHECK(simulation->frame()->controller_outputs[0][0] == 20.0);
}

namespace {

void check_nothing_is_left(const std::string& what) {
  const std::size_t files = open_files();
  {
    auto simulation = simulate(flywheel(trouble(what)), "bullet");
    CHECK(simulation->run_until(0.2) == RunStatus::completed);
    CHECK(descendants(::getpid()).size() >= 2);
  }
  CHECK(descendants(::getpid()).empty());
  CHECK(open_files() == files);
  // Not even a zombie process.
  CHECK(::waitpid(-1, nullptr, WNOHANG) == -1);
}

}  // namespace

TEST_CASE("nothing is left of a controller's process", "[containment]") {
  check_nothing_is_left(GENERATE("nothing", "children", "thread"));
}

TEST_CASE("nothing is left of a controller's process that crashes at its end", "[containment]") {
  if (kSanitized) COGRSIM_SKIP(kCatchesSignals);
  check_nothing_is_left("crash-in-destructor");
}

TEST_CASE("when the simulation is killed its controllers die", "[containment]") {
  const std::string what = GENERATE("nothing", "children", "hang", "thread");
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t run = ::fork();
  REQUIRE(run >= 0);
  if (run == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::execl(COGRSIM_ENDLESS_RUN, "endless", COGRSIM_TEST_CONTROLLERS, what.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  if (what != "hang") {
    char word[8] = {};
    REQUIRE(::read(ends[0], word, sizeof word) == 8);  // "running\n"
  }
  const std::size_t least = what == "children" ? 4 : 2;  // watchdog, controller, its children
  REQUIRE(soon([&] { return descendants(run).size() >= least; }));
  const std::vector<pid_t> processes = descendants(run);
  ::kill(run, SIGKILL);
  ::waitpid(run, nullptr, 0);
  for (const pid_t process : processes) {
    INFO(process);
    CHECK(soon([&] { return !alive(process); }));
  }
  ::close(ends[0]);
}

TEST_CASE("a controller's process has a number of its own", "[containment]") {
  auto simulation = simulate(flywheel(trouble("publish-pid")), "bullet");
  simulation->step();
  const double pid = simulation->frame()->controller_outputs[0][1];
  CHECK(pid != static_cast<double>(::getpid()));
  const auto all = descendants(::getpid());
  CHECK(std::find(all.begin(), all.end(), static_cast<pid_t>(pid)) != all.end());
  // It is killed from outside, as by a system that is out of memory.
  ::kill(static_cast<pid_t>(pid), SIGKILL);
  simulation->run_until(0.1);
  CHECK_THAT(messages_of(*simulation), Contains("crashed (SIGKILL)"));
}

TEST_CASE("a killed watchdog ends its controller and is reported", "[containment]") {
  ControllerModel controller = trouble("publish-pid");
  auto simulation = simulate(flywheel(controller), "bullet");
  simulation->run_until(0.05);
  const auto worker = static_cast<pid_t>(simulation->frame()->controller_outputs[0][1]);
  for (const pid_t process : descendants(::getpid())) {
    if (process != worker) ::kill(process, SIGKILL);
  }
  CHECK(soon([&] { return !alive(worker); }));
  CHECK(simulation->run_until(0.2) == RunStatus::completed);
  CHECK_THAT(messages_of(*simulation), Contains("lost its process in update"));
}

TEST_CASE("a restart begins with a new process and the same run", "[containment]") {
  auto simulation = simulate(flywheel(trouble(kSanitized ? "throw" : "segv")), "bullet");
  simulation->run_until(0.1);
  const std::string once = messages_of(*simulation);
  simulation->send(Restart{});
  simulation->step();
  simulation->run_until(0.1);
  CHECK(messages_of(*simulation) == once + once);
}
