#include "cogrsim/core/run_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

extern char** environ;  // NOLINT: POSIX wants it declared by its user

namespace cogrsim {
namespace {

using Clock = std::chrono::steady_clock;

struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnSettings(const std::string& folder, int output) {
    posix_spawn_file_actions_init(&actions);
    if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
};

std::vector<char*> environment_without(const std::vector<std::string>& prefixes) {
  std::vector<char*> out;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    if (std::none_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string& prefix) { return text.starts_with(prefix); }))
      out.push_back(*entry);
  }
  out.push_back(nullptr);
  return out;
}

// Reads the output until the program closes it.
void read_output(int pipe, pid_t process, const ProgramOptions& options, ProgramEnd& end) {
  const auto deadline = Clock::now() + options.longest;
  char buffer[4096];
  while (true) {
    if (!end.killed && (Clock::now() > deadline || (options.cancelled && options.cancelled()))) {
      ::kill(-process, SIGKILL);
      end.killed = true;
    }
    pollfd waiting{pipe, POLLIN, 0};
    if (::poll(&waiting, 1, 100) <= 0) continue;
    const ssize_t count = ::read(pipe, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    end.output.append(buffer, static_cast<std::size_t>(count));
    if (end.output.size() > 2 * options.most_output)
      end.output.erase(0, end.output.size() - options.most_output);
  }
}

}  // namespace

tl::expected<ProgramEnd, std::error_code> run_program(std::vector<std::string> command,
                                                      const ProgramOptions& options) {
  const auto failed = [](int reason) {
    return tl::unexpected(std::error_code(reason, std::generic_category()));
  };
  int pipe[2];
  if (::pipe2(pipe, O_CLOEXEC) != 0) return failed(errno);
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  std::vector<char*> environment = environment_without(options.unset);
  const SpawnSettings settings(options.folder, pipe[1]);
  pid_t process = 0;
  const int problem = ::posix_spawnp(&process, arguments[0], &settings.actions,
                                     &settings.attributes, arguments.data(), environment.data());
  ::close(pipe[1]);
  if (problem != 0) {
    ::close(pipe[0]);
    return failed(problem);
  }
  ProgramEnd end;
  read_output(pipe[0], process, options, end);
  ::close(pipe[0]);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return end;
}

}  // namespace cogrsim
