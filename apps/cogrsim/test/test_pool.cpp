// Cases of `cogrsim test` in processes of their own.
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/progress.h"
#include "test/test_case.h"
#include "test/test_command.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Child {
  std::size_t number = 0;
  pid_t pid = -1;
  Clock::time_point start;
  bool timed_out = false;
};

/// A folder that is removed with its content.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "cogrsim-test-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  bool there() const { return !path_.empty(); }
  std::string file(std::size_t number, const char* ending) const {
    return (path_ / fmt::format("{}.{}", number, ending)).string();
  }

 private:
  fs::path path_;
};

// "maze.parks_in_front.bullet.3": the name of a recording.
std::string file_name(const TestCase& one) {
  std::string scene = fs::path(one.scene).filename().string();
  std::string name = scene.substr(0, scene.find('.')) + "." + one.test;
  for (const std::string& backend : one.backends)
    if (one.backends.size() == 1) name += "." + backend;
  name += fmt::format(".seed{}", one.seed_used);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return name;
}

std::string last_lines(const std::string& path) {
  std::ifstream in(path);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  constexpr std::size_t kMost = 1000;  // [bytes]
  if (text.size() > kMost) text = "… " + text.substr(text.size() - kMost);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

Json outcome(const Child& child, int status, const ScratchFolder& scratch, double timeout) {
  const std::string said = last_lines(scratch.file(child.number, "err"));
  const std::string tail = said.empty() ? "" : "\n" + said;
  if (child.timed_out)
    return no_result(fmt::format("was ended after {:.6g} s, see --timeout{}", timeout, tail));
  if (WIFSIGNALED(status))
    return no_result(fmt::format("crashed: signal {}, {}{}", WTERMSIG(status),
                                 strsignal(WTERMSIG(status)), tail));
  std::ifstream in(scratch.file(child.number, "out"));
  Json result = Json::parse(in, nullptr, false);
  if (result.is_object() && result.contains("status")) return result;
  return no_result(fmt::format("ended with exit status {}{}", WEXITSTATUS(status), tail));
}

}  // namespace

Result<> run_cases(std::vector<TestCase>& cases, const TestCommandOptions& options,
                   const std::function<void(const TestCase&)>& done,
                   const std::function<void(std::size_t, std::size_t)>& progress) {
  const ScratchFolder scratch;
  if (!scratch.there())
    return fail(fmt::format("cannot make a folder in {}: {}", fs::temp_directory_path().string(),
                            std::strerror(errno)));
  const unsigned processors = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t jobs = options.jobs > 0 ? static_cast<std::size_t>(options.jobs) : processors;
  // Scenes of one name in several folders, and tests whose names differ by a blank only.
  std::vector<std::string> names;
  std::map<std::string, int> taken;
  for (const TestCase& one : cases) {
    names.push_back(file_name(one));
    if (const int count = ++taken[names.back()]; count > 1) {
      names.back() += fmt::format(".{}", count);
    }
  }
  std::vector<Child> children;
  std::size_t next = 0, reported = 0, ended = 0, failed = 0;
  const auto start = [&](std::size_t number) -> Result<> {
    const TestCase& one = cases[number];
    Json input = {
        {"scene", one.scene},
        {"set", options.set},
        {"plugin_paths", options.plugin_paths},
        {"test", one.index},
        {"backends", one.backends},
        {"seed", one.seed ? Json(*one.seed) : Json(nullptr)},
        {"overwrite", output_rules().overwrite},
        {"recording", options.out.empty() ? "" : (fs::path(options.out) / names[number]).string()}};
    const std::string in = scratch.file(number, "in"), out = scratch.file(number, "out"),
                      errors = scratch.file(number, "err");
    std::ofstream(in) << input.dump(-1, ' ', false, Json::error_handler_t::replace);
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid < 0)
      return fail(fmt::format("cannot start a process: {}", std::strerror(errno)), "",
                  "try fewer --jobs");
    if (pid == 0) {  // only calls that are safe between fork and exec
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(126);
      const int said = open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
      const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
      dup2(nothing, STDIN_FILENO);
      dup2(nothing, STDOUT_FILENO);
      dup2(said, STDERR_FILENO);
      execl("/proc/self/exe", "cogrsim", "test-case", in.c_str(), out.c_str(),
            static_cast<char*>(nullptr));
      _exit(126);
    }
    children.push_back({number, pid, Clock::now(), false});
    return {};
  };
  // Whoever writes a recording completes it, see record_again().
  const auto end_all = [&] {
    constexpr double kGrace = 5.0;  // [s]
    for (const Child& child : children) kill(child.pid, SIGTERM);
    const auto asked_at = Clock::now();
    for (const Child& child : children) {
      while (waitpid(child.pid, nullptr, WNOHANG) == 0) {
        if (seconds_since(asked_at) > kGrace) kill(child.pid, SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    }
  };
  while (reported < cases.size()) {
    while (next < cases.size() && children.size() < jobs && !interrupted()) {
      if (auto started = start(next); !started) {
        end_all();
        return started;
      }
      ++next;
    }
    bool any = false;
    for (std::size_t i = 0; i < children.size();) {
      Child& child = children[i];
      const double took = seconds_since(child.start);
      if (options.timeout > 0.0 && took > options.timeout && !child.timed_out) {
        child.timed_out = true;
        kill(child.pid, SIGKILL);
      }
      int status = 0;
      if (waitpid(child.pid, &status, WNOHANG) != child.pid) {
        ++i;
        continue;
      }
      any = true;
      TestCase& one = cases[child.number];
      one.result = outcome(child, status, scratch, options.timeout);
      one.wall_time = took;
      ++ended;
      failed += one.passed() ? 0 : 1;
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
    }
    // A terminal sends Ctrl-C to the cases, too: how they ended now says nothing about them.
    if (interrupted()) {
      end_all();
      return fail(fmt::format("interrupted: {} of {} cases done", reported, cases.size()));
    }
    progress(ended, failed);
    for (; reported < cases.size() && !cases[reported].result.is_null(); ++reported) {
      done(cases[reported]);
    }
    if (!any) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return {};
}

}  // namespace cogrsim::cli
