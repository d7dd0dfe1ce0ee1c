#include "process.h"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace {

using Clock = std::chrono::steady_clock;

std::vector<char*> argument_pointers(const std::vector<std::string>& args) {
  std::vector<char*> pointers = {const_cast<char*>(COGRSIM_PROGRAM)};
  for (const std::string& arg : args) pointers.push_back(const_cast<char*>(arg.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

void take_status(Outcome& outcome, int status) {
  outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + outcome.signal;
}

void wait_for(pid_t child, Outcome& outcome) {
  int status = 0;
  waitpid(child, &status, 0);
  take_status(outcome, status);
}

// Appends the available bytes; false: the other end was closed.
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

// What fills a pipe of one page.
const std::string kFilling(4096, '~');

RunningProgram start(const std::vector<std::string>& args, bool full = false,
                     bool as_nobody = false) {
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  if (full && (fcntl(out[1], F_SETPIPE_SZ, kFilling.size()) != static_cast<int>(kFilling.size()) ||
               write(out[1], kFilling.data(), kFilling.size()) != 4096)) {
    throw std::runtime_error("the pipe cannot be filled");
  }
  std::vector<char*> pointers = argument_pointers(args);
  RunningProgram child;
  child.pid = fork();
  if (child.pid == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    if (as_nobody && !become_nobody()) _exit(127);
    execv(COGRSIM_PROGRAM, pointers.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  child.out = out[0];
  child.err = err[0];
  return child;
}

// Reads both streams to their ends; meanwhile `now_and_then` is called.
void read_to_end(
    const RunningProgram& child, Outcome& outcome,
    const std::function<void()>& now_and_then = [] {}) {
  pollfd ends[2] = {{child.out, POLLIN, 0}, {child.err, POLLIN, 0}};
  std::string* texts[2] = {&outcome.out, &outcome.err};
  int open_ends = 2;
  while (open_ends > 0) {
    poll(ends, 2, 10);
    now_and_then();
    for (int i = 0; i < 2; ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      if (!read_some(ends[i].fd, *texts[i])) {
        close(ends[i].fd);
        ends[i].fd = -1;
        --open_ends;
      }
    }
  }
}

}  // namespace

bool RunningProgram::printed() const {
  int bytes = 0;
  return ioctl(out, FIONREAD, &bytes) == 0 && bytes > 0;
}

bool RunningProgram::has_open(const std::string& path) const {
  std::error_code error;
  const std::filesystem::directory_iterator all("/proc/" + std::to_string(pid) + "/fd", error);
  if (error) return false;
  return std::any_of(begin(all), end(all), [&](const auto& entry) {
    std::error_code gone;
    return std::filesystem::read_symlink(entry.path(), gone) == path;
  });
}

bool RunningProgram::waits_in_a_write() const {
  const std::string call = read_file("/proc/" + std::to_string(pid) + "/syscall");
  return call.rfind(std::to_string(SYS_write) + " ", 0) == 0;
}

Outcome cogrsim_run(const std::vector<std::string>& args, double interrupt_after) {
  const RunningProgram child = start(args);
  Outcome outcome;
  const auto begin = Clock::now();
  bool interrupted = interrupt_after <= 0.0;
  read_to_end(child, outcome, [&] {
    if (interrupted ||
        std::chrono::duration<double>(Clock::now() - begin).count() <= interrupt_after)
      return;
    kill(child.pid, SIGINT);
    interrupted = true;
  });
  wait_for(child.pid, outcome);
  return outcome;
}

Outcome cogrsim_interrupted(const std::vector<std::string>& args, int signal,
                            const std::function<bool(const RunningProgram&)>& at_work, bool full) {
  constexpr std::chrono::seconds kPatience(60);  // a machine that is busy with other things
  const RunningProgram child = start(args, full);
  Outcome outcome;
  const auto begin = Clock::now();
  int status = 0;
  bool ended = false;
  while (!ended && !at_work(child)) {
    ended = waitpid(child.pid, &status, WNOHANG) == child.pid;
    if (Clock::now() - begin > kPatience) signal = SIGKILL;
    if (signal == SIGKILL) break;
    usleep(200);
  }
  if (!ended) kill(child.pid, signal);
  read_to_end(child, outcome);
  if (full) outcome.out.erase(0, kFilling.size());
  if (ended) {
    take_status(outcome, status);
  } else {
    wait_for(child.pid, outcome);
  }
  return outcome;
}

Outcome cogrsim_run_unprivileged(const std::vector<std::string>& args) {
  const RunningProgram child = start(args, false, true);
  Outcome outcome;
  read_to_end(child, outcome);
  wait_for(child.pid, outcome);
  return outcome;
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
  wait_for(child, outcome);
  return outcome;
}

std::set<std::string> listed_commands() {
  std::istringstream help(cogrsim_run({"--help"}).out);
  std::set<std::string> names;
  bool listed = false;
  for (std::string line; std::getline(help, line);) {
    std::istringstream fields(line);
    std::string name;
    if (!(fields >> name)) listed = false;
    if (listed && line.rfind("  ", 0) == 0 && line[2] != ' ') names.insert(name);
    listed = listed || line == "Subcommands:";
  }
  return names;
}

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
