#include "process/watchdog.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <thread>

#include "process/child_process.h"
#include "process/confinement.h"

namespace cogrsim::watchdog {

namespace {

using Clock = std::chrono::steady_clock;

/// The child processes of this process, including adopted orphans; nullopt: the system does not
/// provide the list.
std::optional<std::string> children() {
  const std::string path = "/proc/self/task/" + std::to_string(::getpid()) + "/children";
  std::string out;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  char part[4096];
  for (ssize_t got = 0; (got = ::read(file, part, sizeof part)) > 0;) {
    out.append(part, static_cast<std::size_t>(got));
  }
  ::close(file);
  return out;
}

/// Kills all descendants. When a descendant ends, its children become children of this process.
void clear_away(pid_t worker) {
  const auto last = Clock::now() + std::chrono::seconds(8);
  while (Clock::now() < last) {
    const std::optional<std::string> list = children();
    if (!list) ::kill(-worker, SIGKILL);
    for (const char* at = list ? list->c_str() : ""; *at != '\0';) {
      char* end = nullptr;
      const long pid = std::strtol(at, &end, 10);
      if (end == at) break;
      if (pid > 1) ::kill(static_cast<pid_t>(pid), SIGKILL);
      at = *end == '\0' ? end : end + 1;
    }
    pid_t gone = 0;
    while ((gone = ::waitpid(-1, nullptr, WNOHANG)) > 0) {
    }
    if (gone < 0 && errno == ECHILD) return;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

/// Reports the end first on the socket, which a wild pointer in the controller cannot damage.
void report_end(std::optional<CallChannel>& memory, const ProcessEnd& end) {
  while (::send(kLink, &end, sizeof end, MSG_NOSIGNAL) < 0 && errno == EINTR) {
  }
  if (memory) memory->report_end();
}

/// Runs the worker; does not return.
[[noreturn]] void be_worker(std::optional<CallChannel>& memory, pid_t watchdog_id, pid_t simulation,
                            int (*serve)(CallChannel&), char** command) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Where Yama lets only ancestors trace, a debugger that the simulation has started may, too.
  ::prctl(PR_SET_PTRACER, static_cast<unsigned long>(simulation));
  if (::getppid() != watchdog_id) ::_exit(1);  // the watchdog has already ended
  ::setpgid(0, 0);  // kill(0, …) in a controller must not kill the watchdog
  ::close(kLink);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  if (*command) {
    ::fcntl(kChannel, F_SETFD, 0);
    if (const std::string first = *command; first.rfind(kConfined, 0) == 0) {
      confine(Confinement::from(first.substr(std::strlen(kConfined))));
      ++command;
    }
    ::execvp(*command, command);
    std::fprintf(stderr, "cannot start '%s': %s\n", *command, std::strerror(errno));
    ::_exit(127);
  }
  if (!memory) ::_exit(2);
  // Line buffering, so that the output of a controller is not lost when it crashes.
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::exit(serve(*memory));
}

/// Whether the simulation has left these descriptors open.
bool started_by_simulation(int file) {
  if (::fcntl(file, F_GETFD) >= 0) return true;
  std::fputs("this program is started by CogRSim, for controllers with isolation=\"process\"\n",
             stderr);
  return false;
}

}  // namespace

int serve_as_worker(int (*serve)(CallChannel&)) {
  CallChannel channel;
  if (!started_by_simulation(kChannel) || !channel.open(kChannel)) return 2;
  ::fcntl(kChannel, F_SETFD, FD_CLOEXEC);
  return serve(channel);
}

int run(int (*serve)(CallChannel&), char** command) {
  if (!started_by_simulation(kChannel) || !started_by_simulation(kLink)) return 2;
  ::fcntl(kChannel, F_SETFD, FD_CLOEXEC);
  ::fcntl(kLink, F_SETFD, FD_CLOEXEC);
  ::syscall(SYS_close_range, kLink + 1, ~0U, 0U);  // inherited from the simulation
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  ::signal(SIGPIPE, SIG_IGN);
  sigset_t watched;
  sigemptyset(&watched);
  sigaddset(&watched, SIGCHLD);
  ::sigprocmask(SIG_BLOCK, &watched, nullptr);
  const int signals = ::signalfd(-1, &watched, SFD_CLOEXEC | SFD_NONBLOCK);
  struct stat channel {};
  std::optional<CallChannel> memory;
  if (signals < 0 || ::fstat(kChannel, &channel) != 0) return 2;
  const bool is_socket = S_ISSOCK(channel.st_mode);
  if (!is_socket && !memory.emplace().open(kChannel)) return 2;

  const pid_t own = ::getpid(), simulation = ::getppid();
  const pid_t worker = ::fork();  // safe: this process has only one thread
  if (worker < 0) {
    report_end(memory, {true, 2 << 8, 0});
    return 2;
  }
  if (worker == 0) {
    ::close(signals);
    be_worker(memory, own, simulation, serve, command);
  }
  if (is_socket) ::close(kChannel);  // its end is the end of the worker

  bool over = false;
  while (!over) {
    pollfd watch[2] = {{kLink, POLLIN, 0}, {signals, POLLIN, 0}};
    if (::poll(watch, 2, -1) < 0 && errno != EINTR) break;
    if (watch[0].revents != 0) break;  // the simulation has ended or closed the socket
    signalfd_siginfo info;
    while (::read(signals, &info, sizeof info) > 0) {
    }
    ProcessEnd end;
    end.reported = true;
    rusage used{};
    pid_t gone = 0;
    while ((gone = ::wait4(-1, &end.status, WNOHANG, &used)) > 0) {
      if (gone != worker) continue;
      end.most_bytes = static_cast<std::int64_t>(used.ru_maxrss) * 1024;
      over = true;
      // All other processes end first, so that none is left when the run continues.
      clear_away(worker);
      report_end(memory, end);
      break;
    }
  }
  if (!over) clear_away(worker);
  return 0;
}

}  // namespace cogrsim::watchdog
