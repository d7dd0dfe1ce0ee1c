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
#include <iostream>
#include <iterator>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "common/progress.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kResultDescriptor = 3;
constexpr std::size_t kKeptErrors = 4096;         // [bytes] of a child's standard error
constexpr std::size_t kLongestResult = 16 << 20;  // [bytes]

tl::unexpected<Error> cannot_start() {
  return fail(fmt::format("cannot start a process for a run: {}", std::strerror(errno)), "",
              "try fewer --jobs");
}

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become_case(const char* command, pid_t parent, int input, int result, int errors,
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
  execl("/proc/self/exe", "cogrsim", command, static_cast<char*>(nullptr));
  _exit(126);
}

}  // namespace

Json case_input() {
  const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
  return Json::parse(text, nullptr, false);
}

bool write_case_result(const Json& result) {
  const std::string text = json_text(result);
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = write(kResultDescriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

CasePool::~CasePool() {
  for (const Child& child : children_) {
    kill(child.pid, SIGKILL);
    waitpid(child.pid, nullptr, 0);
    close(child.result);
    close(child.errors);
  }
}

Result<> CasePool::start(std::size_t id, const Json& input) {
  const std::string text = input.dump(-1, ' ', false, Json::error_handler_t::replace);
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
  if (pid == 0) become_case(command_, parent, memory, result[1], errors[1], limits_.memory_limit);
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

void CasePool::drain(Child& child) {
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
    Json result = Json::parse(child.result_text, nullptr, false);
    CaseEnd end{status, child.timed_out, std::move(result), std::move(child.error_text)};
    finished.push_back({child.id, outcome_(std::move(end), limits_), seconds_since(child.start)});
    close(child.result);
    close(child.errors);
    children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Between the closing of its pipes and its end a child makes poll() return at once.
  if (finished.empty() && !children_.empty()) usleep(500);
  return finished;
}

void CasePool::end(double grace) {
  for (const Child& child : children_) kill(child.pid, SIGTERM);
  for (const auto asked_at = Clock::now(); running() > 0 && seconds_since(asked_at) < grace;)
    wait(20);
}

bool run_cases(CasePool& pool, std::size_t count, const std::function<Json(std::size_t)>& input,
               const std::function<void(FinishedCase&)>& take) {
  std::size_t next = 0;
  while (!interrupted() && (next < count || pool.running() > 0)) {
    for (; next < count && pool.has_free_slot(); ++next)
      if (!pool.start(next, input(next))) return false;
    for (FinishedCase& one : pool.wait(100)) take(one);
  }
  return true;
}

}  // namespace cogrsim::cli
