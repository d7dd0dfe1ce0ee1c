// A controller that misbehaves, in its fourth update or elsewhere.
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "cogrsim/control/controller.h"

namespace {

[[gnu::noinline]] int endless(int depth) {
  volatile char here[4096];
  here[0] = static_cast<char>(depth);
  return depth < 0 ? 0 : endless(depth + 1) + here[0];
}

/// Overwrites the memory that is shared with the simulation, as an invalid pointer could.
void scribble() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("cogrsim-controller") == std::string::npos) continue;
    unsigned long begin = 0, end = 0;
    if (std::sscanf(line.c_str(), "%lx-%lx", &begin, &end) != 2) continue;
    std::memset(reinterpret_cast<void*>(begin), 0x33, end - begin);
  }
}

void sleep_long() { std::this_thread::sleep_for(std::chrono::hours(1)); }

/// A process that is never waited for; `own_session`: in a session of its own.
void leave_behind(bool own_session) {
  if (::fork() != 0) return;
  if (own_session) ::setsid();
  sleep_long();
  ::_exit(0);
}

/// A process of its own traces this one, as a debugger would.
void be_traced_by_child() {
  ::prctl(PR_SET_PTRACER, PR_SET_PTRACER_ANY);
  const pid_t traced = ::getpid();
  if (::fork() != 0) return;
  ::ptrace(PTRACE_SEIZE, traced, nullptr, nullptr);
  sleep_long();
  ::_exit(0);
}

class Trouble final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override {
    robot_ = std::make_unique<cogrsim::Assembly>(robot);
    what_ = robot.parameter<std::string>("what");
    motor_ = robot.motor("left");
    if (what_ == "publish-pid") robot.publish("pid", static_cast<double>(::getpid()));
    if (what_ == "crash-in-configure") std::raise(SIGSEGV);
    if (what_ == "mistake") robot.motor("lfet");
    if (what_ == "throw-in-configure") throw std::runtime_error("no calibration file");
  }

  ~Trouble() override {
    if (what_ == "crash-in-destructor") std::raise(SIGSEGV);
  }

  void update(const cogrsim::Tick& tick) override {
    motor_.set(2.0);
    if (tick.count == 3) act();
    robot_->publish("updates", static_cast<double>(tick.count + 1));
  }

  std::optional<std::string> save() const override {
    if (what_ == "crash-in-save") std::raise(SIGBUS);
    if (what_ == "throw-in-save") throw std::runtime_error("no pen");
    return "memory";
  }

 private:
  void act() {
    if (what_ == "segv") {
      volatile int* nowhere = nullptr;
      *nowhere = 1;
    }
    if (what_ == "abort") std::abort();
    if (what_ == "exit") std::exit(3);
    if (what_ == "exit-quietly") ::_exit(0);
    if (what_ == "overflow") std::printf("%d", endless(0));
    if (what_ == "kill") ::kill(0, SIGKILL);
    if (what_ == "stop") std::raise(SIGSTOP);
    if (what_ == "scribble") scribble();
    if (what_ == "stop-watchdog-and-crash") {
      ::kill(::getppid(), SIGSTOP);
      std::raise(SIGSEGV);
    }
    if (what_ == "many-threads") {
      for (int i = 0; i < 1000; ++i) std::thread(sleep_long).detach();
    }
    if (what_ == "throw") throw std::out_of_range("cell 9 of 8");
    if (what_ == "throw-in-thread") {
      std::thread([] { throw std::runtime_error("this is never caught"); }).join();
    }
    if (what_ == "nan") motor_.set(std::numeric_limits<double>::quiet_NaN());
    if (what_ == "hang") sleep_long();
    if (what_ == "traced-by-watchdog") ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    if (what_ == "traced-by-child") be_traced_by_child();
    if (what_ == "spin" || what_.rfind("traced-by", 0) == 0) {
      for (volatile bool on = true; on;) {
      }
    }
    if (what_ == "memory") {
      for (;;) hoard_.emplace_back(10'000'000, 'x');
    }
    if (what_ == "malloc") {
      for (;;) std::memset(std::malloc(10'000'000), 1, 10'000'000);
    }
    if (what_ == "thread") std::thread(sleep_long).detach();
    if (what_ == "children") {
      leave_behind(false);
      leave_behind(true);
    }
    if (what_ == "fork-and-return") {
      if (::fork() == 0) return;
    }
    if (what_ == "print") {
      std::puts("a word on stdout");
      std::fputs("a word on stderr\n", stderr);
    }
    if (what_ == "chatter") {
      for (int i = 0; i < 500; ++i) robot_->report(std::string(1000, 'a'));
    }
  }

  std::unique_ptr<cogrsim::Assembly> robot_;
  std::string what_;
  cogrsim::MotorHandle motor_;
  std::vector<std::vector<char>> hoard_;
};

}  // namespace

COGRSIM_CONTROLLER(Trouble, "trouble", version("1.0.0"), summary("does what it should not"),
                   parameter("what", "nothing", "what to do"), output("updates", "1", "so far"),
                   output("pid", "1", "of its process"))
