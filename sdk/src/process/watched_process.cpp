#include "process/watched_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/runtime_symbol_info.hpp>

#include "process/watchdog.h"

extern char** environ;

namespace cogrsim {

namespace {

/// Time limit for the watchdog to end the processes that the worker has started.
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

struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnSettings(int channel, int link, const WatchedProcess::Options& options) {
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (options.output >= 0) {
      posix_spawn_file_actions_adddup2(&actions, options.output, STDOUT_FILENO);
      posix_spawn_file_actions_adddup2(&actions, options.output, STDERR_FILENO);
    }
    posix_spawn_file_actions_adddup2(&actions, channel, watchdog::kChannel);
    posix_spawn_file_actions_adddup2(&actions, link, watchdog::kLink);
    if (!options.folder.empty())
      posix_spawn_file_actions_addchdir_np(&actions, options.folder.c_str());
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

std::string ProcessEnd::text() const {
  if (!reported) return "lost its process";
  if (!WIFSIGNALED(status))
    return "ended its process (exit code " + std::to_string(WEXITSTATUS(status)) + ")";
  const char* name = ::sigabbrev_np(WTERMSIG(status));
  return "crashed (" +
         (name ? std::string("SIG") + name : "signal " + std::to_string(WTERMSIG(status))) + ")";
}

std::string remedy_of(int problem, const std::string& what) {
  const std::string rest = what + " in a process of its own needs two";
  if (problem == EMFILE || problem == ENFILE)
    return "raise the number of open files with `ulimit -n`: " + rest;
  if (problem == EAGAIN) return "raise the number of processes with `ulimit -u`: " + rest;
  if (problem == ENOENT) return "it belongs next to the plugins; install CogRSim again";
  return "";
}

std::string controller_host_path() {
  std::error_code error;
  const std::filesystem::path own =
      std::filesystem::canonical(boost::dll::this_line_location(), error);
  if (error) return "cogrsim_controller_host";
  return (own.parent_path() / "cogrsim" / "cogrsim_controller_host").string();
}

Result<std::unique_ptr<WatchedProcess>> WatchedProcess::start(int channel, Options options) {
  std::unique_ptr<WatchedProcess> child(new WatchedProcess);
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    const int why = errno;
    return fail(std::string("cannot create a socket: ") + std::strerror(why), "",
                remedy_of(why, options.what));
  }
  child->link_ = ends[0];
  const int link = moved_up(ends[1]);
  const int given = ::fcntl(channel, F_DUPFD_CLOEXEC, watchdog::kFirstFree);
  std::string path = controller_host_path();
  if (options.confined)
    options.command.insert(options.command.begin(), watchdog::kConfined + options.confined->text());
  std::vector<char*> arguments = {path.data()};
  for (std::string& argument : options.command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  int problem = link < 0 || given < 0 ? EMFILE : 0;
  if (problem == 0) {
    SpawnSettings settings(given, link, options);
    problem = ::posix_spawn(&child->watchdog_, path.c_str(), &settings.actions,
                            &settings.attributes, arguments.data(), environ);
    if (problem != 0) child->watchdog_ = -1;
  }
  if (link >= 0) ::close(link);
  if (given >= 0) ::close(given);
  if (problem != 0) {
    return fail("cannot start '" + path + "', the program that runs and watches other processes: " +
                    std::strerror(problem),
                "", remedy_of(problem, options.what));
  }
  return child;
}

WatchedProcess::~WatchedProcess() { kill(); }

bool WatchedProcess::gone() {
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

bool WatchedProcess::receive_end() {
  ProcessEnd end;
  const auto got = ::recv(link_, &end, sizeof end, MSG_DONTWAIT);
  if (got == static_cast<ssize_t>(sizeof end)) end_ = end;
  return end_.reported;
}

void WatchedProcess::kill() {
  if (link_ >= 0) ::close(link_);
  link_ = -1;
  const auto last = std::chrono::steady_clock::now() + kClearing;
  auto nap = std::chrono::microseconds(50);
  while (!gone() && std::chrono::steady_clock::now() < last) {
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
