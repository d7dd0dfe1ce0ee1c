#include "watch/watch_command.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "watch/watch_files.h"
#include "watch/watch_link.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kInterval(250);  // between checks of the files
// A run that is asked to stop does so at its next step, unless a plugin does not return.
constexpr std::chrono::seconds kGrace(2);  // less than a run has itself, see interrupt.h

// ---- the child's side

// Speaks to the parent through a pipe: a list is 'i' (instead) or 'a' (add), its paths, and an empty
// one, each ended by a zero byte.
class PipeLink final : public WatchLink {
 public:
  PipeLink(int pipe, const std::atomic<bool>& superseded) : pipe_(pipe), superseded_(superseded) {}

  void depends_on(const std::vector<std::string>& paths, bool instead) override {
    std::string text(1, instead ? 'i' : 'a');
    for (const std::string& path : paths) {
      if (path.empty()) continue;
      text += path;
      text += '\0';
    }
    text += '\0';
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t count = write(pipe_, text.data() + sent, text.size() - sent);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return;  // the parent has ended
      sent += static_cast<std::size_t>(count);
    }
  }

  bool superseded() const override { return superseded_.load(); }

 private:
  int pipe_;
  const std::atomic<bool>& superseded_;
};

[[noreturn]] void be_child(const RunOptions& options, int pipe, const std::atomic<bool>& superseded,
                           pid_t parent) {
  // Ends with its parent, whatever ends that.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kFailed);
  // Ctrl-C reaches both; the parent decides what it means, and sends SIGTERM.
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGINT);
  sigprocmask(SIG_BLOCK, &blocked, nullptr);
  PipeLink link(pipe, superseded);
  int status = kFailed;
  try {
    status = run_command(options, &link);
  } catch (const std::exception& e) {
    print_error(message_of(e));
  }
  std::fflush(nullptr);
  _exit(status);  // the parent cleans up what both hold
}

// ---- the parent's side

// One run in a process of its own: a plugin that crashes ends only that run, and a library that was
// rebuilt is really loaded again.
class ChildRun {
 public:
  explicit ChildRun(const RunOptions& options) {
    void* shared = mmap(nullptr, sizeof(std::atomic<bool>), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    int ends[2];
    if (shared == MAP_FAILED || pipe2(ends, O_CLOEXEC) != 0) {
      throw std::system_error(errno, std::generic_category(), "cannot start a run");
    }
    superseded_ = new (shared) std::atomic<bool>(false);
    std::fflush(nullptr);  // or both would print what is waiting
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      close(ends[0]);
      be_child(options, ends[1], *superseded_, parent);
    }
    const int reason = errno;
    close(ends[1]);
    pipe_ = ends[0];
    if (pid_ < 0) {
      throw std::system_error(reason, std::generic_category(), "cannot start a run");
    }
  }
  ~ChildRun() {
    end(Clock::now());
    close(pipe_);
    munmap(superseded_, sizeof(std::atomic<bool>));
  }
  ChildRun(const ChildRun&) = delete;
  ChildRun& operator=(const ChildRun&) = delete;

  // Waits at most `time` for lists from the run, and adds them to `files`. False: none came,
  // since the time is over, it has ended, or there was an interrupt.
  bool listen(std::chrono::milliseconds time, WatchedFiles& files) {
    pollfd wait{pipe_, POLLIN, 0};
    if (!open_) wait.fd = -1;  // just waits
    if (::poll(&wait, 1, static_cast<int>(time.count())) <= 0) return false;
    char buffer[4096];
    const ssize_t count = read(pipe_, buffer, sizeof buffer);
    if (count <= 0) {
      open_ = false;
      return false;
    }
    heard_.append(buffer, static_cast<std::size_t>(count));
    take_lists(files);
    return true;
  }

  bool running() {
    if (ended_) return false;
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) != pid_) return true;
    take_status(status);
    return false;
  }

  /// Exit status, as a shell has it for one that a signal ended. Precondition: !running().
  int status() const { return status_; }
  /// Of the signal that ended it; 0: none.
  int signal() const { return signal_; }

  void ask_to_end() {
    if (!ended_) kill(pid_, SIGTERM);
  }
  /// It is not needed any more: no result is to be written.
  void supersede() {
    superseded_->store(true);
    ask_to_end();
  }
  /// Waits until `deadline`, then ends it by force: true if that was necessary.
  bool end(Clock::time_point deadline) {
    while (running()) {
      if (Clock::now() >= deadline) {
        kill(pid_, SIGKILL);
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        take_status(status);
        return true;
      }
      usleep(5000);
    }
    return false;
  }

 private:
  void take_status(int status) {
    ended_ = true;
    signal_ = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : int{kFailed};
  }

  void take_lists(WatchedFiles& files) {
    for (;;) {
      // A list is whole once its empty path has come.
      std::vector<std::string> paths;
      std::size_t at = 1;
      bool whole = false;
      while (at < heard_.size()) {
        const std::size_t end = heard_.find('\0', at);
        if (end == std::string::npos) return;
        if (end == at) {
          whole = true;
          break;
        }
        paths.push_back(heard_.substr(at, end - at));
        at = end + 1;
      }
      if (!whole) return;
      if (heard_[0] == 'i') {
        files.keep_only(paths);
      } else {
        files.add(paths);
      }
      heard_.erase(0, at + 1);
    }
  }

  pid_t pid_ = -1;
  int pipe_ = -1;
  bool open_ = true, ended_ = false;
  int status_ = kFailed, signal_ = 0;
  std::atomic<bool>* superseded_ = nullptr;
  std::string heard_;
};

void say(const std::string& text) {
  const Style style = style_of(STDERR_FILENO);
  std::fputs((style.bold + "watch:" + style.off + " " + text + "\n").c_str(), stderr);
}

// As a user would write it: from here where it is below here.
std::string shown(const std::string& path) {
  std::error_code fault;
  const fs::path from_here = fs::path(path).lexically_relative(fs::current_path(fault));
  const bool below = !fault && !from_here.empty() && *from_here.begin() != fs::path("..");
  return one_line(below ? from_here.string() : path);
}

std::string list_of(const std::vector<std::string>& paths) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < paths.size() && i < kShown; ++i) {
    struct stat info {};
    const bool there = stat(paths[i].c_str(), &info) == 0;
    text += (i > 0 ? ", " : "") + shown(paths[i]) + (there ? "" : " (gone)");
  }
  if (paths.size() > kShown) text += fmt::format(" and {} more", paths.size() - kShown);
  return text;
}

// The files that the run writes are no reason to restart it.
std::vector<std::string> results_of(const RunOptions& options) {
  std::vector<std::string> out;
  for (const std::string& file : {options.json, options.record}) {
    if (!file.empty()) out.push_back(full_path(file));
  }
  for (const RunOptions::Save& save : options.saves) out.push_back(full_path(save.file));
  return out;
}

Result<> check_scene_file(const std::string& scene) {
  struct stat info {};
  if (stat(scene.c_str(), &info) != 0) {
    return fail(fmt::format("cannot watch '{}': {}", scene, std::strerror(errno)));
  }
  if (S_ISREG(info.st_mode)) return {};
  return fail(fmt::format("cannot watch '{}': it is not an ordinary file", scene), "",
              S_ISDIR(info.st_mode) ? "name the scene file in it"
                                    : "what comes through a pipe comes once; save it as a file");
}

void report_end(const ChildRun& run, std::size_t files) {
  if (run.signal() != 0) {
    print_error(
        fmt::format("the run was ended by signal {} ({})", run.signal(), strsignal(run.signal())));
  }
  say(fmt::format("{}; it restarts when one of {} files changes, Ctrl-C ends",
                  run.status() == kGood ? "the run is over" : "the run failed", files));
}

// Waits until a file has changed, and returns the names; empty: the user wants to end.
std::string wait_for_change(ChildRun& run, WatchedFiles& files) {
  bool reported = false;
  auto next_look = Clock::now() + kInterval;
  for (;;) {
    const auto rest = std::chrono::ceil<std::chrono::milliseconds>(next_look - Clock::now());
    run.listen(std::max(rest, std::chrono::milliseconds(0)), files);
    if (interrupted()) return {};
    if (Clock::now() < next_look) continue;
    next_look = Clock::now() + kInterval;
    if (!run.running() && !reported) {
      // All lists of the run are read before its end is reported.
      while (run.listen(std::chrono::milliseconds(0), files)) {
      }
      report_end(run, files.size());
      reported = true;
    }
    const std::vector<std::string> changed = files.poll();
    if (!changed.empty()) return list_of(changed);
  }
}

}  // namespace

int watch_command(const RunOptions& options) {
  if (const auto fit = check_scene_file(options.scene.scene); !fit) {
    return refuse(fit.error());
  }
  catch_interrupts();
  WatchedFiles files(results_of(options));
  files.add({full_path(options.scene.scene)});
  say(fmt::format("{} and what it uses; Ctrl-C ends", shown(full_path(options.scene.scene))));
  for (;;) {
    files.settle();
    ChildRun run(options);
    const std::string changed = wait_for_change(run, files);
    if (changed.empty()) {
      // The usual end of a run, in its own time; a second Ctrl-C ends both at once.
      run.ask_to_end();
      run.end(Clock::time_point::max());
      forget_interrupt();
      return run.status();
    }
    if (run.running()) {
      run.supersede();
      if (run.end(Clock::now() + kGrace)) {
        print_warning(
            fmt::format("the run did not end within {} s of SIGTERM, and was killed\nhelp: does "
                        "a plugin wait for something?",
                        kGrace.count()));
      }
    }
    say(changed + " changed: restarting");
  }
}

}  // namespace cogrsim::cli
