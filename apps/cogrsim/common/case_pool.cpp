#include "common/case_pool.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fmt/format.h>

#include "common/progress.h"
#include "sweep/sweep_case.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kKeptErrors = 4096;         // [bytes] of a child's standard error
constexpr std::size_t kLongestResult = 16 << 20;  // [bytes]

tl::unexpected<Error> cannot_start() {
  return fail(fmt::format("cannot start a process for a run: {}", std::strerror(errno)), "",
              "try fewer --jobs");
}

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become_case(pid_t parent, int input, int result, int errors,
                              std::uint64_t memory_limit) {
  // Out of the terminal's group: Ctrl-C is for the parent, which then ends its children.
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(126);  // it died in between
  // The pipes' ends may have any numbers, those asked for among them.
  const int far_result = fcntl(result, F_DUPFD, 10), far_errors = fcntl(errors, F_DUPFD, 10);
  const int far_input = fcntl(input, F_DUPFD, 10);
  const int nothing = open("/dev/null", O_WRONLY);
  if (far_result < 0 || far_errors < 0 || far_input < 0 || nothing < 0) _exit(126);
  dup2(far_input, STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  dup2(far_errors, STDERR_FILENO);
  dup2(far_result, kResultDescriptor);
  for (int d = kResultDescriptor + 1; d < 256; ++d) close(d);
  if (memory_limit > 0) {
    const rlimit limit{memory_limit, memory_limit};
    setrlimit(RLIMIT_AS, &limit);
  }
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) sigaction(signal, &usual, nullptr);
  execl("/proc/self/exe", "cogrsim", "sweep-case", static_cast<char*>(nullptr));
  _exit(126);
}

// The last two lines with something on them, as they may be shown: what a library said, and who was
// called when it crashed.
std::string last_lines(const std::string& text) {
  std::string said;
  std::size_t end = text.find_last_not_of(" \n\r\t");
  for (int i = 0; i < 2 && end != std::string::npos; ++i) {
    const std::size_t before = text.find_last_of('\n', end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::string line = one_line(text.substr(begin, end - begin + 1));
    said = said.empty() ? line : line + "; " + said;
    if (begin == 0) break;
    end = text.find_last_not_of(" \n\r\t", before);
  }
  return said;
}

}  // namespace

CasePool::~CasePool() {
  for (const Child& child : children_) {
    kill(child.pid, SIGKILL);
    waitpid(child.pid, nullptr, 0);
    close(child.result);
    close(child.errors);
  }
}

Result<> CasePool::start(std::size_t id, const Json& input) {
  const std::string text = input.dump();
  const int memory = memfd_create("case", MFD_CLOEXEC);
  int result[2] = {-1, -1}, errors[2] = {-1, -1};
  const auto close_all = [&] {
    for (const int d : {memory, result[0], result[1], errors[0], errors[1]}) {
      if (d >= 0) close(d);
    }
  };
  if (memory < 0 || write(memory, text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      lseek(memory, 0, SEEK_SET) != 0 || pipe2(result, O_CLOEXEC) != 0 ||
      pipe2(errors, O_CLOEXEC) != 0) {
    const auto failed = cannot_start();
    close_all();
    return failed;
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) become_case(parent, memory, result[1], errors[1], limits_.memory_limit);
  if (pid < 0) {
    const auto failed = cannot_start();
    close_all();
    return failed;
  }
  close(memory);
  close(result[1]);
  close(errors[1]);
  Child child;
  child.id = id;
  child.pid = pid;
  child.result = result[0];
  child.errors = errors[0];
  fcntl(child.result, F_SETFL, O_NONBLOCK);
  fcntl(child.errors, F_SETFL, O_NONBLOCK);
  child.start = Clock::now();
  children_.push_back(std::move(child));
  return {};
}

void CasePool::drain(Child& child) const {
  char buffer[65536];
  const auto read_all = [&](int descriptor, std::string& text, std::size_t keep, bool tail) {
    for (;;) {
      const ssize_t count = read(descriptor, buffer, sizeof buffer);
      if (count <= 0) return;
      text.append(buffer, static_cast<std::size_t>(count));
      if (text.size() > keep) {
        if (tail) {
          text.erase(0, text.size() - keep);
        } else {
          text.resize(keep);
        }
      }
    }
  };
  read_all(child.result, child.result_text, kLongestResult, false);
  read_all(child.errors, child.error_text, kKeptErrors, true);
}

Json CasePool::outcome(const Child& child, int status) const {
  if (child.timed_out) {
    return failed_result("timeout",
                         fmt::format("took longer than {}", elapsed_text(limits_.timeout)));
  }
  const std::string said = last_lines(child.error_text);
  const std::string limited =
      limits_.memory_limit > 0
          ? fmt::format(" (its memory was limited to {} MB)", limits_.memory_limit / 1000000)
          : "";
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return failed_result("crashed", fmt::format("signal {} ({}){}{}", signal, strsignal(signal),
                                                limited, said.empty() ? "" : ": " + said));
  }
  Json result = Json::parse(child.result_text, nullptr, false);
  if (WEXITSTATUS(status) == 0 && result.is_object() && result.contains("status") &&
      result.contains("measures")) {
    return result;
  }
  return failed_result("crashed",
                       fmt::format("ended with exit status {} and without a result{}{}",
                                   WEXITSTATUS(status), limited, said.empty() ? "" : ": " + said));
}

std::vector<FinishedCase> CasePool::wait(int milliseconds) {
  std::vector<pollfd> ends;
  for (const Child& child : children_) {
    ends.push_back({child.result, POLLIN, 0});
    ends.push_back({child.errors, POLLIN, 0});
  }
  poll(ends.data(), ends.size(), milliseconds);
  std::vector<FinishedCase> finished;
  for (std::size_t i = 0; i < children_.size();) {
    Child& child = children_[i];
    drain(child);
    int status = 0;
    const pid_t gone = waitpid(child.pid, &status, WNOHANG);
    if (gone == 0) {
      const double age = seconds_since(child.start);
      if (limits_.timeout > 0.0 && age > limits_.timeout && !child.timed_out) {
        child.timed_out = true;
        kill(child.pid, SIGKILL);
      }
      ++i;
      continue;
    }
    drain(child);
    finished.push_back({child.id, outcome(child, status)});
    close(child.result);
    close(child.errors);
    children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Between the closing of its pipes and its end a child makes poll() return at once.
  if (finished.empty() && !children_.empty()) usleep(500);
  return finished;
}

}  // namespace cogrsim::cli
