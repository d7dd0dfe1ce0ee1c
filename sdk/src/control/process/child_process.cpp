#include "control/process/child_process.h"

#include <fcntl.h>
#include <csignal>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <thread>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/runtime_symbol_info.hpp>

#include "cogrsim/plugin/crash_report.h"
#include "control/process/watchdog.h"

extern char** environ;

namespace cogrsim {

namespace {

/// Time limit for the watchdog to end the processes that the controller has started.
constexpr auto kClearing = std::chrono::seconds(10);

/// Copies a descriptor to a number above those that the program inherits. The copy is closed in
/// every other program.
int moved_up(int file) {
  const int copy = ::fcntl(file, F_DUPFD_CLOEXEC, watchdog::kFirstFree);
  const int why = errno;
  ::close(file);
  errno = why;
  return copy;
}

/// How the user can raise a limit of the system.
std::string remedy(int problem) {
  if (problem == EMFILE || problem == ENFILE) {
    return "raise the number of open files with `ulimit -n`: each controller in a process of "
           "its own needs two, with isolation=\"none\" none";
  }
  if (problem == EAGAIN) {
    return "raise the number of processes with `ulimit -u`: each controller in a process of "
           "its own needs two, with isolation=\"none\" none";
  }
  if (problem == ENOENT) return "it belongs next to the plugins; install CogRSim again";
  return "";
}

struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnSettings(int memory, int link) {
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, memory, watchdog::kMemory);
    posix_spawn_file_actions_adddup2(&actions, link, watchdog::kLink);
    posix_spawnattr_init(&attributes);
    // A process group of its own: the simulation handles Ctrl-C in a terminal.
    posix_spawnattr_setpgroup(&attributes, 0);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
};

}  // namespace

std::string controller_host_path() {
  std::error_code error;
  const std::filesystem::path own =
      std::filesystem::canonical(boost::dll::this_line_location(), error);
  if (error) return "cogrsim_controller_host";
  return (own.parent_path() / "cogrsim" / "cogrsim_controller_host").string();
}

Result<std::unique_ptr<ChildProcess>> ChildProcess::start(std::vector<std::string> command) {
  std::unique_ptr<ChildProcess> child(new ChildProcess);
  if (auto made = child->channel_.create(); !made) {
    return fail(made.error().message, "", remedy(errno));
  }
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    const int why = errno;
    return fail(std::string("cannot create a socket: ") + std::strerror(why), "", remedy(why));
  }
  child->link_ = ends[0];
  const int link = moved_up(ends[1]);
  const int memory = ::fcntl(child->channel_.file(), F_DUPFD_CLOEXEC, watchdog::kFirstFree);
  std::string path = controller_host_path();
  std::vector<char*> arguments = {path.data()};
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  int problem = link < 0 || memory < 0 ? EMFILE : 0;
  if (problem == 0) {
    SpawnSettings settings(memory, link);
    problem = ::posix_spawn(&child->watchdog_, path.c_str(), &settings.actions,
                            &settings.attributes, arguments.data(), environ);
    if (problem != 0) child->watchdog_ = -1;
  }
  if (link >= 0) ::close(link);
  if (memory >= 0) ::close(memory);
  if (problem != 0) {
    return fail("cannot start '" + path +
                    "', the program that runs isolated controllers: " + std::strerror(problem),
                "", remedy(problem));
  }
  return child;
}

ChildProcess::~ChildProcess() { kill(); }

bool ChildProcess::watchdog_gone() {
  if (watchdog_ <= 0) return true;
  int status = 0;
  const pid_t gone = ::waitpid(watchdog_, &status, WNOHANG | WUNTRACED);
  // A watchdog that was stopped by a signal cannot report the end or kill processes.
  if (gone == watchdog_ && WIFSTOPPED(status)) {
    ::kill(watchdog_, SIGCONT);
    return false;
  }
  // ECHILD: other code has waited for it, or SIGCHLD is ignored.
  if (gone == watchdog_ || (gone < 0 && errno == ECHILD)) watchdog_ = -1;
  return watchdog_ <= 0;
}

Result<CallChannel::Answer> ChildProcess::call(const std::vector<char>& request,
                                               std::vector<char>& reply,
                                               std::chrono::duration<double> patience) {
  if (!alive()) return CallChannel::Answer::ended;
  if (auto asked = channel_.ask(request); !asked) return tl::unexpected(asked.error());
  auto deadline = CallChannel::Clock::time_point::max();
  if (patience < std::chrono::hours(24 * 365)) {
    deadline = CallChannel::Clock::now() +
               std::chrono::duration_cast<CallChannel::Clock::duration>(patience);
  }
  const auto answer = channel_.await(
      reply, deadline, [this] { return watchdog_gone(); }, [] { return PluginCall::given_up(); });
  if (answer != CallChannel::Answer::ended || receive_end() || watchdog_gone()) return answer;
  return CallChannel::Answer::broken;  // only the (damaged) shared memory reports the end
}

/// Receives the report of the watchdog about the end; false: there is none.
bool ChildProcess::receive_end() {
  ProcessEnd end;
  const auto got = ::recv(link_, &end, sizeof end, MSG_DONTWAIT);
  if (got == static_cast<ssize_t>(sizeof end)) end_ = end;
  return end_.reported;
}

void ChildProcess::kill() {
  if (link_ >= 0) ::close(link_);
  link_ = -1;
  const auto last = CallChannel::Clock::now() + kClearing;
  auto nap = std::chrono::microseconds(50);
  while (!watchdog_gone() && CallChannel::Clock::now() < last) {
    std::this_thread::sleep_for(nap);
    nap = std::min(2 * nap, std::chrono::microseconds(5000));
  }
  if (watchdog_ <= 0) return;
  ::kill(watchdog_, SIGKILL);
  int status = 0;
  while (::waitpid(watchdog_, &status, 0) < 0 && errno == EINTR) {
  }
  watchdog_ = -1;
}

}  // namespace cogrsim
