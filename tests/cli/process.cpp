#include "process.h"

#include <grp.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace {

using Clock = std::chrono::steady_clock;

std::vector<char*> argument_pointers(const std::vector<std::string>& args) {
  std::vector<char*> pointers = {const_cast<char*>(COGRSIM_PROGRAM)};
  for (const std::string& arg : args) pointers.push_back(const_cast<char*>(arg.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

int status_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Appends what is there to read; false: the other end was closed.
bool read_some(int descriptor, std::string& text) {
  char buffer[4096];
  const ssize_t count = read(descriptor, buffer, sizeof buffer);
  if (count <= 0) return false;
  text.append(buffer, static_cast<std::size_t>(count));
  return true;
}

// Gives up being root, for good.
bool become_nobody() {
  constexpr uid_t kNobody = 65534;
  return geteuid() != 0 ||
         (setgroups(0, nullptr) == 0 && setgid(kNobody) == 0 && setuid(kNobody) == 0);
}

Outcome run(const std::vector<std::string>& args, double interrupt_after, bool as_nobody) {
  int out[2], err[2];
  if (pipe(out) != 0 || pipe(err) != 0) throw std::runtime_error("no pipe");
  std::vector<char*> pointers = argument_pointers(args);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    for (const int end : {out[0], out[1], err[0], err[1]}) close(end);
    if (as_nobody && !become_nobody()) _exit(127);
    execv(COGRSIM_PROGRAM, pointers.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  Outcome outcome;
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* texts[2] = {&outcome.out, &outcome.err};
  const auto start = Clock::now();
  bool interrupted = interrupt_after <= 0.0;
  int open_ends = 2;
  while (open_ends > 0) {
    poll(ends, 2, interrupted ? -1 : 10);
    if (!interrupted &&
        std::chrono::duration<double>(Clock::now() - start).count() > interrupt_after) {
      kill(child, SIGINT);
      interrupted = true;
    }
    for (int i = 0; i < 2; ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      if (!read_some(ends[i].fd, *texts[i])) {
        close(ends[i].fd);
        ends[i].fd = -1;
        --open_ends;
      }
    }
  }
  outcome.status = status_of(child);
  return outcome;
}

}  // namespace

Outcome cogrsim_run(const std::vector<std::string>& args, double interrupt_after) {
  return run(args, interrupt_after, false);
}

Outcome cogrsim_run_unprivileged(const std::vector<std::string>& args) {
  return run(args, 0.0, true);
}

Outcome cogrsim_on_terminal(const std::vector<std::string>& args,
                            const std::vector<std::string>& environment) {
  std::vector<char*> pointers = argument_pointers(args);
  int master = -1;
  winsize size{};
  size.ws_col = 100;
  size.ws_row = 40;
  const pid_t child = forkpty(&master, nullptr, nullptr, &size);
  if (child == 0) {
    setenv("TERM", "xterm", 1);
    unsetenv("NO_COLOR");
    for (const std::string& entry : environment) putenv(const_cast<char*>(entry.c_str()));
    execv(COGRSIM_PROGRAM, pointers.data());
    _exit(127);
  }
  Outcome outcome;
  while (read_some(master, outcome.out)) {
  }
  close(master);
  outcome.status = status_of(child);
  return outcome;
}

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
